"""Standard deviations of a loop in wind and noise: exact, by covariances or over frequency."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, log, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..shaping.pieces import FloatArray
from .axis import Axis
from .controller import Controller
from .disturbances import Wind
from .feedforward import Feedforward
from .models import StateModel
from .open_loop import OpenLoop, open_loop
from .sampled import exponential_less_one, held_model
from .spectrum import Folded, Spectrum

ComplexArray = NDArray[np.complexfloating[Any, Any]]

_DOUBLINGS = 60  # steps of the sum of covariances: 2^60 samples
_PANELS = 40  # a decade of frequency, of 16 points each
_DECADES = (-7.0, 4.0)  # about the frequencies of wind and loop


@dataclass(frozen=True)
class LoopDeviations:
    """Standard deviations of a `ServoLoop` in stationary `Wind` or noise, the command still.

    Attributes
    ----------
    load, motor : float
        Positions, of a digital loop at its samples.
    torque : float
        Torque command.
    load_average : float
        Load's position, the mean square over all time; nan where only the samples are known.
    """

    load: float
    motor: float
    torque: float
    load_average: float


def digital_deviations(
    axis: Axis, controller: Controller, wind: Wind | Spectrum | None, noise: float | Spectrum
) -> LoopDeviations:
    """Return the deviations of a loop in wind, with noise on each sample of the encoder."""
    return _Sampled(axis, controller).deviations(wind, noise)


class _Sampled:
    """A digital loop as one discrete system: states of axis and wind, past torques, controller."""

    def __init__(self, axis: Axis, control: Controller) -> None:
        self.dt, self.delay = float(control.sample_time or 0.0), control.delay
        self.dynamics, self.sensor = axis.dynamics, axis.sensor
        k = control.sampled_model()
        self.k = k.A, k.B, k.C, k.D
        d = self.dynamics
        seen = d.motor if self.sensor == "motor" else d.load
        self.seen = np.array([seen, d.load if self.sensor == "load" else d.motor])
        self.noisy = np.array([1.0, 0.0 if self.sensor == "both" else 1.0])

    def deviations(self, wind: Wind | Spectrum | None, noise: float | Spectrum) -> LoopDeviations:
        white = 0.0 if isinstance(noise, Spectrum) else noise
        rational = wind if isinstance(wind, Wind) and wind.kind != "von_karman" else None
        parts = [self.by_covariance(rational, white)]
        if wind is not None and rational is None:
            parts.append(self.in_wind(wind))
        if isinstance(noise, Spectrum):
            parts.append(self.in_noise(Folded(noise, self.dt)))
        total = np.sqrt(np.square(parts).sum(axis=0))
        return LoopDeviations(*total.tolist())

    def by_covariance(self, wind: Wind | None, noise: float) -> FloatArray:
        """Return the four deviations by the discrete Lyapunov equation."""
        a, b, white = _with_wind(self.dynamics.a, self.dynamics.b, wind)
        n, pad = len(a), len(a) - self.dynamics.size
        seen = np.pad(self.seen, ((0, 0), (0, pad)))
        ac, bc, cc, dc = self.k
        held = _hold(a, b, self.dt, self.delay)
        size = len(held.A)
        asked = np.hstack([-dc @ _wide(seen, size), cc])
        whole = np.block([[held.A, np.zeros((size, len(ac)))], [-bc @ _wide(seen, size), ac]])
        whole[:size] += np.asarray(held.B) @ asked
        jolt = np.concatenate([-held.B @ dc @ self.noisy, -bc @ self.noisy])
        spread = noise**2 * np.outer(jolt, jolt)
        spread[:n, :n] += _gathered(a, white, self.dt)
        covariance = _stationary(whole, spread)
        direct = noise**2 * float((dc @ self.noisy).item()) ** 2
        row = _wide(np.pad(self.dynamics.load, (0, pad))[None], len(whole))[0]
        motor = _wide(np.pad(self.dynamics.motor, (0, pad))[None], len(whole))[0]
        variances = [r @ covariance @ r for r in (row, motor)]
        variances.append((asked @ covariance @ asked.T).item() + direct)
        variances.append(self._average(a, b, white, covariance, asked, noise))
        return np.sqrt(np.maximum(variances, 0.0))

    def _average(
        self,
        a: FloatArray,
        b: FloatArray,
        white: FloatArray,
        covariance: FloatArray,
        asked: FloatArray,
        noise: float,
    ) -> float:
        """Return the mean over a sample of the load's variance, by Gauss and Legendre."""
        n = len(a)
        load = np.pad(self.dynamics.load, (0, n - self.dynamics.size))
        whole = int(self.delay / self.dt * (1.0 + 1e-13))
        rest = max(self.delay - whole * self.dt, 0.0)
        if rest < 1e-12 * self.dt:
            rest = 0.0
        now = _Torques(n, asked, noise * float((self.k[3] @ self.noisy).item()))
        nodes, weights = np.polynomial.legendre.leggauss(12)
        total = 0.0
        for start, end in ((0.0, rest), (rest, self.dt)):
            for x, w in zip(0.5 + 0.5 * nodes, 0.5 * weights, strict=True):
                t = start + (end - start) * float(x)
                change, gained = _flow(a, b, t)
                row, fresh = load @ change, 0.0
                later, latest = now.held(whole), now.held(whole + 1)
                if t < rest:
                    by_state = _wide(row[None], len(covariance))[0]
                    by_state = by_state + (load @ gained) * latest[0]
                    fresh = float(load @ gained) * latest[1]
                else:
                    after, recent = _flow(a, b, t - rest)
                    first = _flow(a, b, rest)[1] if rest else np.zeros(n)
                    by_state = _wide(row[None], len(covariance))[0]
                    by_state = by_state + (load @ after @ first) * latest[0]
                    by_state = by_state + (load @ recent) * later[0]
                    fresh = float(load @ recent) * later[1]
                own = load @ _gathered(a, white, t) @ load
                variance = by_state @ covariance @ by_state + fresh**2 + own
                total += float(w) * (end - start) / self.dt * float(variance)
        return total

    def in_wind(self, wind: Wind | Spectrum) -> FloatArray:
        """Return the four deviations by the integral over all frequencies of the wind."""
        push = self.dynamics.b[:, 1 + (wind.on == "load")]

        def responses(f: FloatArray) -> FloatArray:
            s = np.asarray(2j * pi * f, dtype=complex)
            states = _resolvent(self.dynamics.a, push, s)
            return self._squares(np.exp(s * self.dt), self.seen @ states, states)

        return np.sqrt(_over_frequencies(wind, responses, self.dynamics.a, 0.5 / self.dt))

    def in_noise(self, noise: Folded) -> FloatArray:
        """Return the four deviations by the integral up to half the sample rate."""

        def responses(f: FloatArray) -> FloatArray:
            z = np.exp(np.asarray(2j * pi * f, dtype=complex) * self.dt)
            errors = np.outer(self.noisy, np.ones(f.size))
            return self._squares(z, errors, np.zeros((self.dynamics.size, f.size)))

        return np.sqrt(_over_frequencies(noise, responses, self.dynamics.a, 0.5 / self.dt))

    def _squares(self, z: ComplexArray, seen: Any, states: Any) -> FloatArray:
        """Return the squares of what the loop makes of what is seen, and moves, without it."""
        held = _hold(self.dynamics.a, self.dynamics.b[:, 0], self.dt, self.delay)
        following = _resolvent(np.asarray(held.A), np.asarray(held.B)[:, 0], z)
        following = following[: self.dynamics.size]
        ac, bc, cc, dc = self.k
        k = np.array([cc @ _resolvent(ac, column, z) for column in bc.T])[:, 0] + dc.T
        loop = (k * (self.seen @ following)).sum(axis=0)
        u = -(k * seen).sum(axis=0) / (1.0 + loop)
        moved = states + following * u
        rows = [self.dynamics.load @ moved, self.dynamics.motor @ moved, u]
        return np.asarray(np.abs(np.array([*rows, np.full_like(u, np.nan)])) ** 2)


class _Torques:
    """Rows and fresh noise of the torque asked for some samples ago, over the whole state."""

    def __init__(self, n: int, asked: FloatArray, fresh: float) -> None:
        self.n, self.asked, self.fresh = n, asked[0], fresh

    def held(self, ago: int) -> tuple[FloatArray, float]:
        if ago == 0:
            return self.asked, self.fresh
        return np.eye(len(self.asked))[self.n + ago - 1], 0.0


def continuous_deviations(
    axis: Axis, controller: Controller, wind: Wind | Spectrum | None, noise: Spectrum | None
) -> LoopDeviations:
    """Return the deviations of a continuous loop in wind, with noise of the measured position."""
    whole = open_loop(axis, controller, Feedforward()).without_idle_integral()
    a, _ = whole.closed()
    _check_stable(np.linalg.eigvals(a).real.max() < 0.0)
    variances = np.zeros(3)
    if wind is not None:
        variances += _in_wind(axis, whole, wind)
    if noise is not None:
        variances += _in_noise(axis, whole, controller, noise)
    load, motor, torque = np.sqrt(variances).tolist()
    return LoopDeviations(load, motor, torque, load)


def _in_wind(axis: Axis, loop: OpenLoop, wind: Wind | Spectrum) -> FloatArray:
    """Return variances of load, motor and torque of a continuous loop in wind."""
    from scipy.linalg import solve_continuous_lyapunov

    a, _ = loop.closed()
    n, d = len(a), axis.dynamics
    rows = np.array([_wide(row[None], n)[0] for row in (d.load, d.motor)] + [loop.asked[:n]])
    push = loop.disturbed[:, int(wind.on == "load")]
    if isinstance(wind, Spectrum) or wind.kind == "von_karman":

        def responses(f: FloatArray) -> FloatArray:
            return np.asarray(
                np.abs(rows @ _resolvent(a, push, np.asarray(2j * pi * f, dtype=complex))) ** 2
            )

        return _over_frequencies(wind, responses, a, inf)
    whole, _, white = _with_wind(a, np.column_stack([push] * 3), wind)
    covariance = solve_continuous_lyapunov(whole, -white)
    wide = np.array([_wide(r[None], len(whole))[0] for r in rows])
    return np.asarray(np.einsum("ij,jk,ik->i", wide, covariance, wide))


def _in_noise(axis: Axis, loop: OpenLoop, controller: Controller, noise: Spectrum) -> FloatArray:
    """Return variances of load, motor and torque of a continuous loop whose sensor is noisy."""
    d, (a, fed) = axis.dynamics, loop.closed()
    n = len(a)
    if axis.sensor != "both":
        law, seen = controller.transfer(), d.motor if axis.sensor == "motor" else d.load

    def responses(f: FloatArray) -> FloatArray:
        s = np.asarray(2j * pi * f, dtype=complex)
        if axis.sensor == "both":  # of the position alone: as the command, but for its rate
            u = -loop.asked[:n] @ _resolvent(a, fed[:, 0], s) - loop.asked[n]
        states = _resolvent(d.a, d.b[:, 0], s)
        if axis.sensor != "both":
            k = law(s)
            u = -k / (1.0 + k * (seen @ states))
        moved = np.array([d.load @ states, d.motor @ states, np.ones(f.size)]) * u
        return np.asarray(np.abs(moved) ** 2)

    return _over_frequencies(noise, responses, a, inf)


def _with_wind(
    a: FloatArray, b: FloatArray, wind: Wind | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return A and b of the torque with the wind's states, and its white noise's intensity."""
    n = len(a)
    if wind is None:
        return a, b[:, 0], np.zeros((n, n))
    omega = 2.0 * pi * float(wind.corner_hz or 0.0)
    states = 1 if wind.kind == "first_order" else 2
    whole, white = np.zeros((n + states, n + states)), np.zeros((n + states, n + states))
    whole[:n, :n], whole[:n, n] = a, b[:, 1 + (wind.on == "load")]
    for i in range(n, n + states):
        whole[i, i] = -omega
    if states == 2:
        whole[n, n + 1] = omega
    white[-1, -1] = wind.sigma**2 * omega * (2.0 if states == 1 else 4.0)
    return whole, np.append(b[:, 0], np.zeros(states)), white


def _hold(a: FloatArray, b: FloatArray, dt: float, delay: float) -> StateModel:
    return held_model(StateModel(a, b[:, None], np.eye(len(a)), np.zeros((len(a), 1))), dt, delay)


def _wide(rows: FloatArray, size: int) -> FloatArray:
    return np.pad(rows, ((0, 0), (0, size - rows.shape[1])))


def _flow(a: FloatArray, b: FloatArray, t: float) -> tuple[FloatArray, FloatArray]:
    """Return e^(At) and the integral of e^(As)·b from 0 to t."""
    change, integral = exponential_less_one(a, t)
    return np.eye(len(a)) + change, integral @ b


def _gathered(a: FloatArray, white: FloatArray, t: float) -> FloatArray:
    """Return ∫_0^t e^(As)·W·e^(Aᵀs) ds: by quadrature over a fraction of t, doubled."""
    if not white.any() or t == 0.0:
        return np.zeros_like(white)
    norm = float(np.abs(a).sum(axis=0).max()) * t
    doublings = max(ceil(np.log2(norm)), 0) if norm > 1.0 else 0
    step = t * 0.5**doublings
    nodes, weights = np.polynomial.legendre.leggauss(16)
    total, one = np.zeros_like(white), np.eye(len(a))
    for x, w in zip(0.5 * step * (nodes + 1.0), 0.5 * step * weights, strict=True):
        moved = one + exponential_less_one(a, float(x))[0]
        total += w * moved @ white @ moved.T
    for i in range(doublings):
        moved = one + exponential_less_one(a, step * 2.0**i)[0]
        total = total + moved @ total @ moved.T
    return total


def _check_stable(stable: bool) -> None:
    if not stable:
        raise ValueError(
            "the loop is unstable: it has no stationary deviations; see loop_margins(loop)"
        )


def _stationary(whole: FloatArray, spread: FloatArray) -> FloatArray:
    """Return the sum over k of Φ^k·Q·Φᵀ^k, its number of terms doubled again and again."""
    _check_stable(float(np.abs(np.linalg.eigvals(whole)).max()) < 1.0)
    total, power = spread, whole
    for _ in range(_DOUBLINGS):
        more = power @ total @ power.T
        total, power = total + more, power @ power
        if np.abs(more).max() <= 1e-18 * np.abs(total).max():
            break
    return total


def _resolvent(a: FloatArray, b: FloatArray, points: ComplexArray) -> ComplexArray:
    """Return (s − A)⁻¹·b at points, (n, N)."""
    matrices = points[:, None, None] * np.eye(len(a)) - a
    right = np.broadcast_to(b[:, None].astype(complex), (len(points), len(a), 1))
    return np.asarray(np.linalg.solve(matrices, right)[:, :, 0].T)


def _over_frequencies(
    random: Wind | Spectrum | Folded, responses: Any, a: FloatArray, nyquist: float
) -> FloatArray:
    """Return the integral of a spectrum times squared responses, over log frequency.

    Panels end where the spectrum bends, at the axis's own frequencies, near which they are as
    narrow as the damping, and at the Nyquist frequency.
    """
    own = np.linalg.eigvals(a)
    own = own[np.abs(own) > 1e-6 * np.abs(own).max(initial=0.0)]
    swinging = own[np.abs(own.imag) > 0.0]
    bends = np.log(random.bends_hz)
    centre = [*bends, *np.log(np.abs(own) / (2.0 * pi))]
    low, high = min(centre) + _DECADES[0] * 2.3, max(centre) + _DECADES[1] * 2.3
    least, most = random.reach_hz
    low, high = max(low, log(least) if least else -inf), min(high, log(most) if most < inf else inf)
    edges = [np.linspace(low, high, max(int((high - low) / 2.3 * _PANELS), 2)), bends]
    for pole in swinging[swinging.imag > 0.0]:
        damping = max(abs(pole.real) / abs(pole), 1e-6)
        away = damping * np.sinh(np.linspace(-12.0, 12.0, 97)) * 0.5
        away = away[np.abs(away) < 0.5]
        edges.append(np.log(abs(pole.imag) / (2.0 * pi)) + away)
    if nyquist < inf:
        edges.append(np.log(2.0 * nyquist * np.arange(1, 40)))
    whole = np.unique(np.concatenate(edges))
    whole = whole[(whole >= low) & (whole <= high)]
    nodes, weights = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(whole)
    x = (0.5 * (whole[1:] + whole[:-1]))[:, None] + half[:, None] * nodes
    f = np.exp(x).ravel()
    density = random.spectrum(f) * f * (half[:, None] * weights).ravel()
    return np.asarray((responses(f) * density).sum(axis=1))
