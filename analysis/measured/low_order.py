"""A model of low order with error bars out of a measured plant: inertia, friction, modes, delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import Literal, NamedTuple

import numpy as np

from ...plant import Axis, FlexibleMode
from ...shaping.checks import finite, one_of, whole
from ...shaping.frozen import Frozen
from ...shaping.told import Told
from .axis_model import PER_MODE, RIGID, AxisModel, Free
from .measured_response import MeasuredResponse, as_measured
from .rational_fits import Real

_MOST_MODES = 6
_PATIENCE = 2  # further modes that are tried in vain
_SETTLED, _MOST_ROUNDS = 1e-6, 60  # of the sum of squares
_STARTS, _POOR = 4, 3.0  # first guesses that are refined, until a misfit is below
_BEYOND = 3.0  # times the last line: a spring's resonance that tells no inertia
_FAR = 0.5  # of |G|: half the lines farther off, and it is no such axis
_SURE = 3.0  # standard deviations of a friction or spring that is told from none


@dataclass(frozen=True, repr=False)
class FittedAxis(Told, Frozen):
    """A model of a measured plant and how sure its numbers are.

    Attributes
    ----------
    axis : Axis
        Simulates, surveys and leaves as an FMU like any other.
    delay, delay_sigma : float
        Computing delay in seconds besides the hold; give it to the Controller.
    inertia_sigma, viscous_sigma, spring_sigma : float
        Of friction and spring also where they are not told from none.
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
    spring_sigma: float
    frequencies_hz_sigma: tuple[float, ...]
    dampings_sigma: tuple[float, ...]
    gains_sigma: tuple[float, ...]
    misfit: float

    def __str__(self) -> str:
        lines = [f"J {self.axis.J:.6g} ± {self.inertia_sigma:.2g}"]
        if self.axis.viscous:
            lines.append(f"viscous {self.axis.viscous:.6g} ± {self.viscous_sigma:.2g}")
        if self.axis.spring:
            lines.append(f"spring {self.axis.spring:.6g} ± {self.spring_sigma:.2g}")
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
    measured: MeasuredResponse,
    *,
    modes: int | None = None,
    delay: float | None = None,
    sensor: Literal["motor", "load"] | None = None,
) -> FittedAxis:
    """Return an axis of low order that follows a measured plant.

        G(s) = F_lm/(1 + (v·s + k)·F_mm),   F = (1/s² + Σ g/(s² + 2ζ_k·ω_k·s + ω_k²))/J,

    held, delayed and sampled; g is a_k·b_k from motor to load, a_k² at the motor, where friction v
    and spring k act. The poles of the modes by weighted vector fitting, then all numbers by
    weighted least squares; their error bars from its Jacobian, times the root of a misfit above 1.

    Of a sensor at the load a_k² can hardly be told apart from the damping: it is taken to be
    |g| to within a factor of e, which is in the error bars.

    Parameters
    ----------
    measured : MeasuredResponse or control.FrequencyResponseData
        A plant. With `integrators` declared 2 it moves freely, with 1 against friction, with 0
        against a spring, too; else friction and spring are kept where they are 3σ from none.
    modes : int, optional
        How many, 0 to 6. Default: as many as Schwarz's criterion says.
    delay : float, optional
        Computing delay where it is known; it can hardly be told from modes above the lines.
        Default: fitted, of a response without dt too.
    sensor : "motor" or "load", optional
        Where the position was measured. Default: at the motor if all gains are above zero.

    Returns
    -------
    FittedAxis

    Raises
    ------
    ValueError
        For a response that is not a plant's, has more than two integrators, or does not show an
        inertia.
    """
    measured = as_measured(measured, plant=True)
    if measured.kind != "plant":
        raise ValueError(
            f"kind = {measured.kind!r}: expected a plant; plant_response(frf, controller) makes "
            "one of the others"
        )
    integrators = measured.integrators
    if max(measured.fits.power if integrators is None else integrators, 0) > 2:
        raise ValueError(
            f"a plant with {measured.fits.power if integrators is None else integrators} "
            "integrators: expected 2 (free inertia), 1 (viscous friction) or 0 (spring); declare "
            "integrators=…, or measure the plant without its controller"
        )
    if sensor is not None:
        one_of("sensor", sensor, ("motor", "load"))
    asked = _Asked(measured, None if delay is None else finite("delay", delay), sensor)
    acting = Free(integrators is None or integrators < 2, not integrators)
    if modes is not None:
        found = _solved(asked, whole("modes", modes, 0, _MOST_MODES), acting)
    else:
        found = _most_likely(asked, acting)
    if integrators is None:
        found = _only_seen(asked, found)
    off = found.model.response(found.x) / measured.response - 1.0
    swings = np.sqrt(found.x[2]) / (2.0 * pi) > _BEYOND * measured.frequency_hz[-1]
    if swings or not found.sigma_of(0) < 0.5 or np.median(abs(off)) > _FAR:
        raise ValueError(
            "no inertia is seen in the response: expected a plant of one that falls by 40 dB a "
            "decade above the resonance of a spring; measure higher frequencies, or give modes"
        )
    return _as_fitted(found)


class _Asked(NamedTuple):
    measured: MeasuredResponse
    delay: float | None
    sensor: str | None


class _Fit(NamedTuple):
    """Numbers of a model with their covariance, misfit and Schwarz's criterion."""

    model: AxisModel
    x: Real
    covariance: Real
    misfit: float
    cost: float
    friction_sigma: float = 0.0
    spring_sigma: float = 0.0

    def sigma_of(self, place: int) -> float:
        """Return the standard deviation of a number."""
        return float(np.sqrt(max(self.covariance[place, place], 0.0)))

    def per_inertia_sigma(self, place: int) -> float:
        """Return that of a number times J, where x holds it over J."""
        by = np.array([-self.x[place], 1.0])
        some = self.covariance[np.ix_([0, place], [0, place])]
        return float(np.exp(-self.x[0]) * np.sqrt(max(by @ some @ by, 0.0)))


def _most_likely(asked: _Asked, acting: Free) -> _Fit:
    """Return the fit of the number of modes that Schwarz's criterion prefers."""
    best, vain = _solved(asked, 0, acting), 0
    for count in range(1, _MOST_MODES + 1):
        found = _solved(asked, count, acting)
        if found.cost < best.cost:
            best, vain = found, 0
        else:
            vain += 1
        if vain == _PATIENCE:
            break
    return best


def _only_seen(asked: _Asked, both: _Fit) -> _Fit:
    """Return a fit without the friction and the spring that are not told from none."""
    spring = both.per_inertia_sigma(2)
    if both.x[2] * np.exp(-both.x[0]) > _SURE * spring:
        return both
    damped = _solved(asked, both.model.count, Free(friction=True, spring=False), both)
    friction = damped.per_inertia_sigma(1)
    if damped.x[1] * np.exp(-damped.x[0]) > _SURE * friction:
        return damped._replace(spring_sigma=spring)
    free = _solved(asked, both.model.count, Free(friction=False, spring=False), damped)
    return free._replace(friction_sigma=friction, spring_sigma=spring)


def _solved(asked: _Asked, count: int, free: Free, like: _Fit | None = None) -> _Fit:
    """Return the fit of so many modes with what acts on the motor, begun at another fit or anew."""
    if like is not None:
        start = like.x.copy()
        start[1:3] *= free
        return _refined(replace(like.model, free=free), start)
    model, starts = _begun(asked, count, free)
    best = _refined(model, starts[0])
    for start in starts[1:_STARTS]:
        if best.misfit < _POOR:
            break
        best = min(best, _refined(model, start), key=lambda fit: fit.cost)
    return best


def _refined(model: AxisModel, start: Real) -> _Fit:
    """Return the fit by least squares from first guesses on."""
    from scipy.optimize import least_squares

    some = model.fitted
    low, high = (np.full(len(start), edge) for edge in (-np.inf, np.inf))
    low[1:3], low[RIGID + 1 :: PER_MODE], high[RIGID + 1 :: PER_MODE] = 0.0, 0.0, 0.99
    low[RIGID + 2 :: PER_MODE] = 0.0 if model.at_motor else -np.inf
    low[RIGID::PER_MODE], high[RIGID::PER_MODE] = model.edges

    def whole_of(part: Real) -> Real:
        x = start.copy()
        x[some] = part
        return x

    found = least_squares(
        lambda part: model.residual(whole_of(part)),
        np.clip(start, low, high)[some],
        bounds=(low[some], high[some]),
        x_scale="jac",
        ftol=_SETTLED,
        max_nfev=_MOST_ROUNDS,
    )
    x, rows = whole_of(found.x), len(found.fun)
    freedom = rows - some.sum() - model.count * (not model.shaped)
    misfit = float((found.fun**2).sum() / max(freedom, 1))
    covariance = np.zeros((len(x), len(x)))
    covariance[np.ix_(some, some)] = _inverse(found.jac) * max(misfit, 1.0)
    cost = float((found.fun**2).sum() + some.sum() * np.log(rows))
    return _Fit(model, x, covariance, misfit, cost)


def _begun(asked: _Asked, count: int, free: Free) -> tuple[AxisModel, list[Real]]:
    """Return a model with its sensor, and first guesses of its numbers."""
    measured, delay, sensor = asked
    model = AxisModel(measured, count, free, delay, at_motor=sensor == "motor")
    starts = model.starts()
    if sensor is None and (starts[0][RIGID + 2 :: PER_MODE] > 0.0).all():
        model = replace(model, at_motor=True)
        starts = model.starts() if any(free) else starts
    return model, starts


def _inverse(jacobian: Real) -> Real:
    """Return (JᵀJ)⁻¹, of columns of any size."""
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-100)
    inner = np.linalg.pinv((jacobian / scale).T @ (jacobian / scale), rcond=1e-14)
    return np.asarray(inner / np.outer(scale, scale))


def _as_fitted(found: _Fit) -> FittedAxis:
    model, x, inertia = found.model, found.x, float(np.exp(-found.x[0]))
    shapes = x[RIGID:].reshape(-1, PER_MODE)
    order = np.argsort(shapes[:, 0]).tolist()

    def mode(k: int) -> FlexibleMode:
        log_omega, zeta, gain, log_motor = shapes[k].tolist()
        own = np.exp(0.5 * log_motor) if model.shaped else max(np.sqrt(abs(gain)), 1e-12)
        return FlexibleMode(
            float(np.exp(log_omega)) / (2.0 * pi),
            zeta,
            motor_shape=float(own),
            load_shape=float(gain / own),
        )

    def bars(of_mode: int) -> list[float]:
        return [found.sigma_of(RIGID + PER_MODE * k + of_mode) for k in order]

    modes = [mode(k) for k in order]
    free = model.free
    return FittedAxis(
        Axis(
            inertia,
            viscous=float(x[1]) * inertia if free.friction else 0.0,
            spring=float(x[2]) * inertia if free.spring else 0.0,
            modes=modes,
            sensor="motor" if model.at_motor else "load",
        ),
        float(x[3]),
        found.sigma_of(3),
        inertia * found.sigma_of(0),
        found.per_inertia_sigma(1) if free.friction else found.friction_sigma,
        found.per_inertia_sigma(2) if free.spring else found.spring_sigma,
        tuple(m.frequency_hz * bar for m, bar in zip(modes, bars(0), strict=True)),
        tuple(bars(1)),
        tuple(bars(2)),
        found.misfit,
    )
