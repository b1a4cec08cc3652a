"""Many open-loop transfers L(s), rational with a delay, on arrays: their values and slopes."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .factored_loop import Complex, Real
from .imaginary_axis import set_on_axis
from .many_roots import degrees, roots, trimmed
from .many_turning_points import turning_points
from .turning_points import TOUCH_TOLERANCE

Mask = npt.NDArray[np.bool_]

BESIDE = 1e-9
"""Frequencies this near, relative to one another, are taken for the same."""

_FAR = 1e8
_HIGHEST = 1e200
_MOST = 600.0
_TURN = 2.0 * np.pi


class Slopes(NamedTuple):
    """ln |L|, turns, and the first two derivatives of ln L by ln ω."""

    gain: Real
    turns: Real
    first: Complex
    second: Complex


@dataclass(frozen=True, eq=False)
class Loops:
    """L(s) = e^g·s^k·N(s)/D(s)·e^(−τs) of B loops, in units of `scale` rad/s.

    N and D are rows of coefficients in ascending powers, with N(0) and D(0) other than zero.
    Phases are counted in turns from −π: L is real and negative where `turns` is whole.

    Attributes
    ----------
    log_gain, power, delay, scale : (B,) arrays
        g, k, τ and the unit.
    offset : (B,) array
        Turns of the factors other than s − z, s − p and e^(−τs), in quarters.
    hidden : (B,) array of bool
        Whether a zero hides a pole on the axis: no feedback can move it.
    numerator, denominator : (B, M + 1) and (B, N + 1) arrays
    zeros, poles : (B, M) and (B, N) arrays of complex
        Roots of N and D.
    """

    log_gain: Real
    power: Real
    delay: Real
    scale: Real
    offset: Real
    hidden: Mask
    numerator: Real
    denominator: Real
    zeros: Complex
    poles: Complex

    def __len__(self) -> int:
        return len(self.power)

    def take(self, rows: Any) -> Loops:
        """Return some of the loops."""
        return Loops(*(getattr(self, field.name)[rows] for field in fields(self)))

    @cached_property
    def ends(self) -> tuple[Real, Real]:
        """Frequencies below and above which L is its asymptote, every |L| = 1 between them."""
        return _ends(self)

    @cached_property
    def rise(self) -> Real:
        """The power of s that L tends to at high frequencies, (B,)."""
        return self.power + degrees(self.numerator) - degrees(self.denominator)

    @cached_property
    def limits(self) -> tuple[Real, Real]:
        """Return ln |L| at ω = 0 and ω → ∞, (B,)."""
        first, last = (_asymptote(self, at_end) for at_end in (False, True))
        low = np.where(self.power == 0, first, -np.inf * self.power)
        high = np.where(self.rise == 0, last, np.inf * self.rise)
        return low, high

    @cached_property
    def turns_at_limits(self) -> tuple[Real, Real]:
        """Return the turns at ω = 0 and those of the rational part at ω → ∞, exact quarters."""
        quarters = [
            np.rint(4.0 * _turned(np.full((len(self), 1), end), self.zeros, self.poles)[:, 0])
            for end in (0.0, np.inf)
        ]
        return self.offset + 0.25 * quarters[0], self.offset + 0.25 * quarters[1]

    @property
    def endless(self) -> Mask:
        """Which loops stand no delay at all, (B,): |L| ≥ 1 as ω → ∞."""
        return np.asarray(self.limits[1] >= -TOUCH_TOLERANCE)

    @property
    def beside(self) -> float:
        """How near to a root of the axis a frequency is beside it, relative."""
        return BESIDE

    def turning_points(self) -> tuple[Real, Real]:
        """Return ω, nan for none, among them all where the gain turns, and where the phase."""
        return turning_points(self.numerator, self.denominator, self.power, self.delay)

    def radians(self, omega: Real) -> Real:
        """Return frequencies in radians a unit of time."""
        return omega

    def gain(self, omega: Real) -> Real:
        """Return ln |L(jω)| at (B, K) frequencies."""
        alpha, beta = omega / (1.0 + omega), 1.0 / (1.0 + omega)
        return self._gain(omega, *(_on_axis(part, alpha, beta) for part in self._parts))

    def gain_and_turns(self, omega: Real) -> tuple[Real, Real]:
        """Return ln |L(jω)| and its turns at (B, K) frequencies."""
        alpha, beta = omega / (1.0 + omega), 1.0 / (1.0 + omega)
        values = [_on_axis(part, alpha, beta) for part in self._parts]
        return self._gain(omega, *values), self._turns(omega, *values)

    def slopes(self, omega: Real) -> Slopes:
        """Return everything at (B, K) frequencies."""
        alpha, beta = omega / (1.0 + omega), 1.0 / (1.0 + omega)
        values, first, second = [], [], []
        for part in self._parts:
            index = np.arange(part.shape[1])
            value = _on_axis(part, alpha, beta)
            s_p = _on_axis(part * index, alpha, beta) / value
            s_s_p = _on_axis(part * (index * (index - 1)), alpha, beta) / value
            values.append(value)
            first.append(s_p)
            second.append(s_p + s_s_p - s_p * s_p)
        lag = 1j * self.delay[:, None] * omega
        return Slopes(
            self._gain(omega, *values),
            self._turns(omega, *values),
            self.power[:, None] + first[0] - first[1] - lag,
            second[0] - second[1] - lag,
        )

    @property
    def _parts(self) -> tuple[Real, Real]:
        return self.numerator, self.denominator

    def _gain(self, omega: Real, numerator: Complex, denominator: Complex) -> Real:
        ratio = np.log(abs(numerator)) - np.log(abs(denominator))
        excess = self.numerator.shape[1] - self.denominator.shape[1]
        wide = self.log_gain[:, None] + self.power[:, None] * np.log(omega)
        return np.asarray(np.clip(ratio + wide + excess * np.log1p(omega), -_MOST, _MOST))

    def _turns(self, omega: Real, numerator: Complex, denominator: Complex) -> Real:
        """Roots tell how often the phase turns, the coefficients where it is within a turn."""
        counted = _turned(omega, self.zeros, self.poles) + self.offset[:, None]
        turns = (np.angle(numerator) - np.angle(denominator)) / _TURN
        turns += 0.5 + 0.25 * self.power[:, None]
        turns += np.rint(counted - turns)
        return turns - omega * (self.delay[:, None] / _TURN)


def loops_of(numerator: Real, denominator: Real, delay: Real) -> Loops:
    """Return loops from rows of coefficients, the highest power first, no row all zeros."""
    (n, n_low), (d, d_low) = (trimmed(part[:, ::-1]) for part in (numerator, denominator))
    power = n_low - d_low
    unit = _unit(n, d, power, delay)
    (n, n_exponent), (d, d_exponent) = (_in_units(part, unit) for part in (n, d))
    log_gain = np.log(2.0) * (n_exponent - d_exponent + power * unit)
    zeros, poles = (set_on_axis(roots(part)) for part in (n, d))
    opposite = (_leading(n) < 0.0) != (_leading(d) < 0.0)
    return Loops(
        log_gain,
        power.astype(float),
        np.ldexp(delay, unit),
        np.exp2(unit.astype(float)),
        0.5 + 0.25 * power + 0.5 * opposite,
        _cancelled(zeros, poles) | (np.minimum(n_low, d_low) > 0),
        *(n, d, zeros, poles),
    )


def _leading(rows: Real) -> Real:
    return np.asarray(rows[np.arange(len(rows)), degrees(rows)])


def _turned(omega: Real, zeros: Complex, poles: Complex) -> Real:
    """Return the turns of all s − z less those of all s − p."""
    return (_arguments(omega, zeros) - _arguments(omega, poles)) / _TURN


def _cancelled(zeros: Complex, poles: Complex) -> Mask:
    """Which loops have a pole on the axis, other than at 0, where there is a zero, (B,)."""
    on_axis = (poles.real == 0.0) & (poles.imag > 0.0)
    hidden = np.zeros(len(poles), dtype=bool)
    [some] = np.nonzero(on_axis.any(axis=1))
    gaps = abs(poles[some, :, None] - np.where(np.isfinite(zeros), zeros, np.inf)[some, None, :])
    near = (gaps <= BESIDE * abs(poles[some])[:, :, None]).any(axis=2)
    hidden[some] = (on_axis[some] & near).any(axis=1)
    return hidden


def _unit(numerator: Real, denominator: Real, power: Real, delay: Real) -> Real:
    """Return the power of two next to the geometric mean of the corner frequencies."""
    rows = np.arange(len(power))
    count = np.zeros(len(power))
    total = np.zeros(len(power))
    for part in (numerator, denominator):
        degree = degrees(part)
        count += degree
        total += np.log2(abs(part[:, 0])) - np.log2(abs(part[rows, degree]))
    level = np.log2(abs(numerator[:, 0])) - np.log2(abs(denominator[:, 0]))
    crossing = np.where(power != 0, -level / power, np.where(delay > 0, -np.log2(delay), 0.0))
    mean = np.where(count > 0, total / count, crossing)
    return np.rint(mean).astype(int)


def _in_units(rows: Real, unit: Real) -> tuple[Real, Real]:
    """Return polynomials of s in units of 2^unit, and the power of two taken out of them."""
    mantissa, exponent = np.frexp(rows)
    exponent = exponent + unit[:, None] * np.arange(rows.shape[1])
    largest = np.where(rows != 0, exponent, np.iinfo(np.int64).min).max(axis=1, initial=-(2**60))
    scaled = np.ldexp(mantissa, np.maximum(exponent - largest[:, None], -4000))
    return scaled[:, : degrees(scaled).max(initial=0) + 1], largest


def _on_axis(rows: Real, alpha: Real, beta: Real) -> Complex:
    """Return P(jω)/(1 + ω)^degree, with α = ω/(1 + ω) and β = 1/(1 + ω): it cannot overflow."""
    last = rows.shape[1] - 1
    real, imaginary = np.broadcast_to(rows[:, last, None], alpha.shape), np.zeros_like(alpha)
    power = np.ones_like(alpha)
    for i in range(last - 1, -1, -1):
        power = power * beta
        real, imaginary = rows[:, i, None] * power - alpha * imaginary, alpha * real
    value = np.empty(alpha.shape, dtype=complex)
    value.real, value.imag = real, imaginary
    return value


def _arguments(omega: Real, found: Complex) -> Real:
    """Sum of arg(jω − r) over the roots, continuous; a root on the axis is passed on its right."""
    total = np.zeros(omega.shape)
    for root in found.T:
        real, imaginary = root.real[:, None], root.imag[:, None]
        angle = np.arctan2(omega - imaginary, abs(real))
        angle = np.where(real > 0, np.pi - angle, angle)
        total += np.where(np.isfinite(real), angle, 0.0)
    return total


def _asymptote(loops: Loops, at_end: bool) -> Real:
    """Return ln |c| of the asymptote c·s^k at the lowest or highest frequencies, (B,)."""
    rows = np.arange(len(loops))
    coefficients = [
        part[rows, degrees(part) if at_end else 0] for part in (loops.numerator, loops.denominator)
    ]
    return np.asarray(loops.log_gain + np.log(abs(coefficients[0])) - np.log(abs(coefficients[1])))


def _ends(loops: Loops) -> tuple[Real, Real]:
    low, high = np.full(len(loops), np.inf), np.zeros(len(loops))
    rows = np.arange(len(loops))
    for part in (loops.numerator, loops.denominator):
        logs = np.log(abs(part))
        degree = degrees(part)
        for i in range(1, part.shape[1]):
            low = np.fmin(low, np.exp((logs[:, 0] - logs[:, i]) / i))
            below = degree - i
            corner = np.exp((logs[rows, below] - logs[rows, degree]) / i)
            high = np.where(below >= 0, np.fmax(high, corner), high)
    for at_end, slope in ((False, loops.power), (True, loops.rise)):
        crossing = np.exp(-_asymptote(loops, at_end) / slope)
        crossing = np.where(slope != 0, crossing, np.nan)
        if (crossing > _HIGHEST / _FAR).any() or (crossing < _FAR / _HIGHEST).any():
            raise ValueError(
                "a loop has |L| = 1 so far from its zeros and poles that frequencies leave the "
                "range of a double: choose units nearer to the problem's own"
            )
        low, high = np.fmin(low, crossing), np.fmax(high, crossing)
    pace = np.where(loops.delay > 0, 1.0 / loops.delay, np.nan)
    low, high = np.fmin(low, pace), np.fmax(high, pace)
    low = np.where(np.isfinite(low), low, 1.0)
    high = np.where(high > 0, high, 1.0)
    return np.maximum(low / _FAR, 1.0 / _HIGHEST), np.minimum(high * _FAR, _HIGHEST)
