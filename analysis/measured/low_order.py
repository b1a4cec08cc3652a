"""A model of low order with error bars out of a measured plant: inertia, friction, modes, delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from ...plant import Axis, FlexibleMode
from ...shaping.checks import finite, whole
from ...shaping.frozen import Frozen
from ...shaping.told import Told
from .measured_response import MeasuredResponse
from .rational_fits import Complex, Real
from .vector_fit import mode_poles, pair_basis

_ALIASES = np.arange(-4, 5)
_MOST_MODES = 6
_DELAYS = 5  # first guesses, from none to two samples


@dataclass(frozen=True, repr=False)
class FittedAxis(Told, Frozen):
    """A model of a measured plant and how sure its numbers are.

    Attributes
    ----------
    axis : Axis
        Simulates, surveys and leaves as an FMU like any other.
    delay, delay_sigma : float
        Computing delay in seconds besides the hold; give it to the Controller.
    inertia_sigma, viscous_sigma : float
    frequencies_hz_sigma, dampings_sigma, gains_sigma : tuple of float
        Of the modes in ascending order; a gain is motor shape times load shape.
    misfit : float
        Mean square of (measured − model)/σ per degree of freedom, expected 1.
    """

    axis: Axis
    delay: float
    delay_sigma: float
    inertia_sigma: float
    viscous_sigma: float
    frequencies_hz_sigma: tuple[float, ...]
    dampings_sigma: tuple[float, ...]
    gains_sigma: tuple[float, ...]
    misfit: float

    def __str__(self) -> str:
        lines = [f"J {self.axis.J:.6g} ± {self.inertia_sigma:.2g}"]
        if self.axis.viscous:
            lines.append(f"viscous {self.axis.viscous:.6g} ± {self.viscous_sigma:.2g}")
        rows = zip(self.axis.modes, self.frequencies_hz_sigma, self.dampings_sigma, strict=True)
        lines += [
            f"mode {mode.frequency_hz:.6g} ± {f:.2g} Hz, damping {mode.damping:.4g} ± {z:.2g}"
            for mode, f, z in rows
        ]
        return "\n".join(
            [
                *lines,
                f"delay {self.delay:.4g} ± {self.delay_sigma:.2g} s",
                f"misfit {self.misfit:.3g} (1 expected)",
            ]
        )


def fit_axis(
    measured: MeasuredResponse, *, modes: int | None = None, delay: float | None = None
) -> FittedAxis:
    """Return an axis of low order that follows a measured plant.

        G(s) = 1/(J·s² + v·s) + Σ g_k/(J·(s² + 2ζ_k·ω_k·s + ω_k²)),   held, delayed and sampled

    The poles of the modes by weighted vector fitting, then all numbers by weighted least squares
    on the sampled model; their error bars from its Jacobian, times the root of a misfit above 1.
    With gains above zero alone the sensor is taken to be at the motor, where the friction acts.

    Parameters
    ----------
    measured : MeasuredResponse
        A plant with one or two integrators, declared or by its slope.
    modes : int, optional
        How many, 0 to 6. Default: as many as Schwarz's criterion says.
    delay : float, optional
        Computing delay where it is known; it can hardly be told from modes above the lines.
        Default: fitted, of a response without dt too.

    Raises
    ------
    ValueError
        For a response that is not a plant's, or a plant without integrator.
    """
    if measured.kind != "plant":
        raise ValueError(
            f"kind = {measured.kind!r}: expected a plant; plant_response(frf, controller) makes "
            "one of the others"
        )
    power = measured.fits.power if measured.integrators is None else measured.integrators
    if power not in (1, 2):
        raise ValueError(
            f"a plant with {power} integrators: expected 1 (viscous friction) or 2 (free inertia); "
            "declare integrators=…, measure lower frequencies"
        )
    if delay is not None:
        delay = finite("delay", delay)
    if modes is not None:
        return _fitted(measured, power, whole("modes", modes, 0, _MOST_MODES), delay)[0]
    best: tuple[float, FittedAxis] | None = None
    for count in range(_MOST_MODES + 1):
        found, cost = _fitted(measured, power, count, delay)
        if best is not None and cost >= best[0]:
            break
        best = cost, found
    assert best is not None
    return best[1]


@dataclass(frozen=True)
class _Problem:
    measured: MeasuredResponse
    power: int
    count: int
    delay: float | None

    @property
    def sigma(self) -> Real:
        return self.measured.fits.sigma

    def model(self, x: Real) -> Complex:
        """Return the sampled response for parameters: ln 1/J, ln v/J, τ, then ln ω, ln ζ, g."""
        lines, dt = self.measured.frequency_hz, self.measured.dt
        s: Complex = np.asarray(2j * pi * lines)
        if dt is None:
            return np.asarray(self._continuous(s, x) * np.exp(-s * x[2]))
        total = np.zeros(len(lines), dtype=complex)
        for k in _ALIASES:
            shifted: Complex = np.asarray(s + 2j * pi * k / dt)
            hold = (1.0 - np.exp(-s * dt)) / (shifted * dt)
            total += self._continuous(shifted, x) * hold * np.exp(-shifted * x[2])
        return total

    def _continuous(self, s: Complex, x: Real) -> Complex:
        modes = self.modes(x)
        swing = np.zeros(len(s), dtype=complex)
        for omega, zeta, gain in modes:
            swing += gain / (s * s + 2.0 * zeta * omega * s + omega**2)
        if self.power == 2:
            total = 1.0 / s**2 + swing
        elif all(gain > 0.0 for _, _, gain in modes):  # where friction acts is what is measured
            free = 1.0 / s**2 + swing
            total = free / (1.0 + np.exp(x[1]) * s * free)
        else:
            total = 1.0 / (s * (s + np.exp(x[1]))) + swing
        return np.asarray(np.exp(x[0]) * total)

    def modes(self, x: Real) -> list[tuple[float, float, float]]:
        """Return (ω, ζ, g) of each mode."""
        rows = x[3:].reshape(-1, 3)
        return [(float(np.exp(w)), float(np.exp(z)), float(g)) for w, z, g in rows]

    def residual(self, x: Real) -> Real:
        """Return what is left in standard deviations, real and imaginary parts."""
        off = (self.model(x) - self.measured.response) / self.sigma * np.sqrt(2.0)
        return np.concatenate([off.real, off.imag])

    def start(self, delay: float) -> Real:
        """Return parameters by vector fitting, with a delay taken out."""
        lines, dt = self.measured.frequency_hz, self.measured.dt
        s: Complex = np.asarray(2j * pi * lines)
        behind = np.exp(-s * delay)
        if dt is not None:
            behind = behind * (1.0 - np.exp(-s * dt)) / (s * dt)
        response = self.measured.response / behind
        weight = abs(behind) / self.sigma
        rigid = np.stack([1.0 / s**2, np.ones_like(s)], axis=1)
        if self.power == 1:
            rigid = np.concatenate([rigid, (1.0 / s)[:, None]], axis=1)
        poles = (
            mode_poles(s, response, weight, rigid, self.count)
            if self.count
            else np.empty(0, dtype=complex)
        )
        low = slice(0, max(6, len(lines) // 40))
        corner = 2.0 * pi * lines[0]
        size = float(np.median(abs(response[low] * s[low] ** 2)))
        x = [np.log(size), np.log(corner), delay]
        basis = np.concatenate([rigid, pair_basis(s, poles)], axis=1) * weight[:, None]
        right = response * weight
        stacked = np.concatenate([basis.real, basis.imag])
        scale = np.maximum(np.linalg.norm(stacked, axis=0), 1e-300)
        solved = np.linalg.lstsq(stacked / scale, np.concatenate([right.real, right.imag]))[0]
        found = solved / scale
        if self.power == 2 and found[0] > 0.0:
            x[0] = np.log(found[0])
        parts = found[rigid.shape[1] :].reshape(-1, 2)
        for pole, (_, odd) in zip(poles, parts, strict=True):
            gain = -2.0 * odd * pole.imag / np.exp(x[0])
            x += [np.log(abs(pole)), np.log(max(-pole.real / abs(pole), 1e-4)), gain]
        return np.array(x)


def _fitted(
    measured: MeasuredResponse, power: int, count: int, delay: float | None
) -> tuple[FittedAxis, float]:
    """Return the model of so many modes and Schwarz's criterion of it."""
    from scipy.optimize import least_squares

    problem = _Problem(measured, power, count, delay)
    step = measured.dt or 0.05 / measured.frequency_hz[-1]
    guesses = [delay] if delay is not None else (np.linspace(0.0, 2.0, _DELAYS) * step).tolist()
    starts = [problem.start(guess) for guess in guesses]
    start = min(starts, key=lambda x: float((problem.residual(x) ** 2).sum()))
    free = np.ones(len(start), dtype=bool)
    free[1], free[2] = power == 1, delay is None
    scale = np.ones(len(start))
    scale[2] = step
    scale[5::3] = np.maximum(abs(start[5::3]), 1e-3)

    def whole_of(part: Real) -> Real:
        x = start.copy()
        x[free] = part * scale[free]
        return x

    found = least_squares(
        lambda part: problem.residual(whole_of(part)), start[free] / scale[free], method="lm"
    )
    x = whole_of(found.x)
    freedom = max(len(found.fun) - free.sum(), 1)
    misfit = float((found.fun**2).sum() / freedom)
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * max(misfit, 1.0)
    deviations = np.zeros(len(x))
    deviations[free] = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * scale[free]
    cost = float((found.fun**2).sum() + free.sum() * np.log(len(found.fun)))
    return _as_axis(problem, x, deviations, misfit), cost


def _as_axis(problem: _Problem, x: Real, deviations: Real, misfit: float) -> FittedAxis:
    inertia = float(np.exp(-x[0]))
    viscous = float(np.exp(x[1])) * inertia if problem.power == 1 else 0.0
    modes = problem.modes(x)
    order = np.argsort([omega for omega, _, _ in modes]).astype(int).tolist()
    rows = deviations[3:].reshape(-1, 3)
    alike = all(gain > 0.0 for _, _, gain in modes)

    def mode(k: int) -> FlexibleMode:
        omega, zeta, gain = modes[k]
        shapes: Any = (np.sqrt(gain), np.sqrt(gain)) if alike else (1.0, gain)
        return FlexibleMode(
            omega / (2.0 * pi),
            min(zeta, 0.99),
            motor_shape=float(shapes[0]),
            load_shape=float(shapes[1]),
        )

    axis = Axis(inertia, viscous=viscous, modes=[mode(k) for k in order])
    if not alike:
        axis = replace(axis, sensor="load")
    return FittedAxis(
        axis,
        float(x[2]),
        float(deviations[2]),
        inertia * float(deviations[0]),
        viscous * float(np.hypot(deviations[1], deviations[0])),
        tuple(float(modes[k][0] * rows[k, 0] / (2.0 * pi)) for k in order),
        tuple(float(modes[k][1] * rows[k, 1]) for k in order),
        tuple(float(rows[k, 2]) for k in order),
        misfit,
    )
