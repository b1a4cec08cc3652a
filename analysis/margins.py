"""Stability margins of a single-input, single-output negative-feedback loop.

The open-loop transfer L(s) is held as zeros, poles and gain. Where the slope of a quantity
(gain, phase, a sensitivity) vanishes on the imaginary axis is a secular equation in ω²,

    Σ wᵢ/(ω² + rᵢ²) = 0,    rᵢ the zeros and poles,

whose roots cut the axis into pieces on which that quantity is monotone. Each piece is then
searched for the one crossing it can hold, on L(jω) itself. No frequency grid is laid, so no
narrow peak falls between two points, and no product of polynomials is expanded.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import control

Real = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

TOUCH_TOLERANCE = 1e-12
"""A gain (nepers) or phase (rad) extremum this near a level is said to touch it."""

DAMPING_FLOOR = 1e-10
"""A closed-loop pole whose damping ratio is not above this counts as undamped."""

_AXIS = 1e-13
_ILL_POSED = 1e-13
_HUGE = 1e250


@dataclass(frozen=True, eq=False)
class LoopMargins:
    """Margins of a negative-feedback loop with open-loop transfer L(s).

    With S = 1/(1 + L) and T = L/(1 + L). A margin that nothing limits is inf and its frequency
    nan. A frequency is 0 or inf where the value is a limit, reached at DC or as ω → ∞. An
    unstable loop has no margins: all are nan, while the crossings of L stay listed.

    Attributes
    ----------
    stable : bool
        Whether every closed-loop pole has a damping ratio above `DAMPING_FLOOR`.
    closed_loop_poles : ndarray of complex, shape (n,)
        In rad/s, the slowest decay first, hidden modes included; read-only.
    crossover_hz : float
        Gain crossover where the phase margin is taken.
    crossovers_hz : tuple of float
        All frequencies with |L| = 1, ascending, tangential touches included.
    phase_margin_deg : float
        Smallest angle, in either direction, from L to −1 over all crossovers.
    lower_gain_margin_db, upper_gain_margin_db : float
        How far the gain may fall, and rise, before the loop is unstable; both positive.
    lower_gain_margin_hz, upper_gain_margin_hz : float
        Where L is real and negative at those gains.
    phase_crossovers_hz : tuple of float
        All frequencies where L is finite, real and negative, ascending.
    delay_margin_s, delay_margin_hz : float
        Smallest added delay that destabilises, and its crossover. The delay is 0 where
        |L| ≥ 1 as ω → ∞.
    modulus_margin, modulus_margin_hz : float
        min |1 + L|, the distance from −1.
    disk_margin, disk_margin_hz : float
        2·min |(1 + L)/(1 − L)|, the symmetric disk margin (skew 0).
    sensitivity_peak, sensitivity_peak_hz : float
        max |S|.
    complementary_peak, complementary_peak_hz : float
        max |T|.
    bandwidth_hz : float
        Where |T| first falls to |T(0)|/√2; nan if it never does, or if T(0) = 0.
    """

    stable: bool
    closed_loop_poles: Complex
    crossovers_hz: tuple[float, ...]
    phase_crossovers_hz: tuple[float, ...]
    crossover_hz: float = math.nan
    phase_margin_deg: float = math.nan
    lower_gain_margin_db: float = math.nan
    lower_gain_margin_hz: float = math.nan
    upper_gain_margin_db: float = math.nan
    upper_gain_margin_hz: float = math.nan
    delay_margin_s: float = math.nan
    delay_margin_hz: float = math.nan
    modulus_margin: float = math.nan
    modulus_margin_hz: float = math.nan
    disk_margin: float = math.nan
    disk_margin_hz: float = math.nan
    sensitivity_peak: float = math.nan
    sensitivity_peak_hz: float = math.nan
    complementary_peak: float = math.nan
    complementary_peak_hz: float = math.nan
    bandwidth_hz: float = math.nan

    def __post_init__(self) -> None:
        """Keep a read-only copy of the poles."""
        poles = np.array(self.closed_loop_poles, dtype=complex)
        poles.setflags(write=False)
        object.__setattr__(self, "closed_loop_poles", poles)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain numbers and lists, ready for JSON.

        inf and nan, which JSON lacks, become None; a pole becomes [real part, imaginary part].
        """
        plain = {field.name: _plain(getattr(self, field.name)) for field in fields(self)}
        poles = self.closed_loop_poles
        return plain | {"closed_loop_poles": [[pole.real, pole.imag] for pole in poles.tolist()]}

    def summary(self) -> str:
        """Return the margins as text, one to a line; an unstable loop names its worst pole."""
        if not self.stable:
            return _unstable_summary(self)
        rows = [
            ("phase margin", f"{self.phase_margin_deg:.4g} deg", self.crossover_hz),
            ("lower gain margin", f"{self.lower_gain_margin_db:.4g} dB", self.lower_gain_margin_hz),
            ("upper gain margin", f"{self.upper_gain_margin_db:.4g} dB", self.upper_gain_margin_hz),
            ("delay margin", f"{self.delay_margin_s:.4g} s", self.delay_margin_hz),
            ("modulus margin", f"{self.modulus_margin:.4g}", self.modulus_margin_hz),
            ("disk margin", f"{self.disk_margin:.4g}", self.disk_margin_hz),
            ("peak of S", f"{self.sensitivity_peak:.4g}", self.sensitivity_peak_hz),
            ("peak of T", f"{self.complementary_peak:.4g}", self.complementary_peak_hz),
        ]
        lines = [f"{name:<18} {value:>12}{_place(hz)}" for name, value, hz in rows]
        bandwidth = "none" if math.isnan(self.bandwidth_hz) else f"{self.bandwidth_hz:.4g} Hz"
        return "\n".join(["stable", *lines, f"{'bandwidth':<18} {bandwidth:>12}"])

    def __str__(self) -> str:
        return self.summary()


def loop_margins(system: "control.StateSpace | control.TransferFunction") -> LoopMargins:
    """Return the margins of the unity negative-feedback loop around `system`.

    Lower and upper gain margins are found apart, over every frequency where L is real and
    negative, DC and ω → ∞ included, so conditionally stable loops come out whole.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
        Open-loop transfer L(s): one input, one output, continuous time, in rad/s. An ideal
        (improper) transfer function is accepted.

    Returns
    -------
    LoopMargins
        Frequencies in Hz, gains in dB, angles in degrees, delay in seconds.

    Raises
    ------
    TypeError
        If `system` is neither of the two types.
    ValueError
        If `system` has several inputs or outputs, is discrete in time, has coefficients that
        are not finite, or if 1 + L vanishes as ω → ∞ (an ill-posed loop).

    Notes
    -----
    Well-conditioned loops come out to about 1e-12 relative, whatever the unit of time. An
    expanded polynomial of high order limits what can be known of its roots; a state space of
    the same loop in physical coordinates keeps more, but one whose states are mixtures of very
    different size may keep four digits. A pole and a zero that cancel still count in stability,
    not in crossings. A loop with |L| = 1 or real L at every frequency has no isolated crossings;
    what is listed then means nothing, and unless it is static the loop is unstable.

    Examples
    --------
    >>> import control
    >>> margins = loop_margins(control.tf([1], [1, 1, 0]))
    >>> round(margins.phase_margin_deg, 3), margins.upper_gain_margin_db
    (51.827, inf)
    """
    _validate(system)
    loop = _factor(system)
    poles = np.asarray(np.concatenate([loop.closed, loop.hidden]) * loop.scale, dtype=complex)
    crossovers, phase_crossovers = _gain_crossings(loop), _phase_crossings(loop)
    stable = _is_stable(poles)
    margins = _margins(loop, crossovers, phase_crossovers) if stable else {}
    return LoopMargins(
        stable=stable,
        closed_loop_poles=poles[np.argsort(-poles.real, kind="stable")],
        crossovers_hz=tuple(loop.hertz(omega) for omega in crossovers),
        phase_crossovers_hz=tuple(loop.hertz(omega) for omega in phase_crossovers),
        **margins,
    )


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _place(hz: float) -> str:
    if math.isnan(hz):
        return ""
    return " as f → ∞" if math.isinf(hz) else f" at {hz:.4g} Hz"


def _unstable_summary(margins: LoopMargins) -> str:
    pole = complex(margins.closed_loop_poles[0]) + 0.0
    crossovers = ", ".join(f"{hz:.4g}" for hz in margins.crossovers_hz) or "none"
    return f"UNSTABLE: closed-loop pole at {pole:.4g} rad/s\ngain crossovers (Hz): {crossovers}"


def _validate(system: Any) -> None:
    import control

    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise TypeError(
            f"system is a {type(system).__name__}; loop_margins takes a control.StateSpace or "
            "control.TransferFunction: convert it with control.ss or control.tf"
        )
    if (system.noutputs, system.ninputs) != (1, 1):
        raise ValueError(
            f"system has {system.ninputs} inputs and {system.noutputs} outputs; loop_margins "
            "takes one of each: pick a channel with system[i, j], the other loops closed"
        )
    if system.isdtime(strict=True):
        raise ValueError(
            f"system is discrete in time (dt = {system.dt}), which is not supported yet; "
            "loop_margins takes continuous time: pass the continuous design, its sampling "
            "delay as a Padé approximation (control.pade)"
        )
    if not all(np.isfinite(part).all() for part in _coefficients(system)):
        raise ValueError(
            "system has coefficients that are nan or inf; loop_margins takes finite ones: "
            "check the parameters it was built from"
        )


def _coefficients(system: Any) -> tuple[Real, ...]:
    if hasattr(system, "A"):
        parts: tuple[Any, ...] = (system.A, system.B[:, 0], system.C[0], system.D[0, 0])
    else:
        parts = (system.num_array[0, 0], system.den_array[0, 0])
    return tuple(np.array(part, dtype=float) for part in parts)


@dataclass(frozen=True, eq=False)
class _Loop:
    """L as zeros, poles and gain, in units of `scale` rad/s.

    `closed` and `opposite` are the roots of 1 + L and 1 − L; `hidden` the modes that no chain of
    coefficients joins to both input and output: they count in stability alone.
    """

    zeros: Complex
    poles: Complex
    gain: float
    closed: Complex
    opposite: Complex
    hidden: Complex
    scale: float

    def hertz(self, omega: float) -> float:
        return float(omega * self.scale / (2 * np.pi))

    def log_gain(self, omega: Real) -> Real:
        """Natural logarithm of |L(jω)|, kept finite on zeros and poles of the axis."""
        s = 1j * omega[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            total = np.log(abs(self.gain)) + np.log(abs(s - self.zeros)).sum(axis=1)
            total = total - np.log(abs(s - self.poles)).sum(axis=1)
        return _finite(total, math.log(_HUGE))

    def phase(self, omega: Real) -> Real:
        """Continuous arg L(jω) in rad for ω > 0, jumping by π only at roots on the axis."""
        turn = _arguments(omega, self.zeros).sum(axis=1) - _arguments(omega, self.poles).sum(axis=1)
        return np.asarray(turn + (np.pi if self.gain < 0 else 0.0))

    def value(self, omega: float) -> complex:
        """L(jω), at the limits ω = 0 and inf too; a limit of inf comes out huge, with its sign."""
        if omega == 0 or math.isinf(omega):
            return complex(np.clip(self.limit(omega), -_HUGE, _HUGE))
        return complex(self.values(np.array([omega]))[0])

    def values(self, omega: Real) -> Complex:
        """L(jω) for ω > 0."""
        return np.asarray(np.exp(self.log_gain(omega) + 1j * self.phase(omega)))

    def limit(self, omega: float) -> float:
        """L where ω = 0 or inf: a real number, inf if unbounded."""
        ends = (self.zeros, self.poles)
        order = sum(sign * _order(roots, omega) for sign, roots in zip((1, -1), ends, strict=True))
        if self.gain == 0 or order:
            return math.inf if order < 0 and self.gain else 0.0
        if math.isinf(omega):
            return self.gain
        factors = [np.log(abs(roots[roots != 0])).sum() for roots in ends]
        sign = np.cos(self.phase_limit(0.0))
        return float(np.sign(sign) * np.exp(np.log(abs(self.gain)) + factors[0] - factors[1]))

    def phase_limit(self, omega: float) -> float:
        """Limit of `phase` as ω falls to 0 or grows to inf: a whole number of right angles."""
        if math.isinf(omega):
            quarters = 2 * (self.gain < 0) + self.zeros.size - self.poles.size
        else:
            origin = sum(self.zeros == 0) - sum(self.poles == 0)
            quarters = np.round(self.phase(np.zeros(1))[0] / (np.pi / 2)) + origin
        return float(quarters * np.pi / 2)

    def log_derivative(self, omega: Real) -> Complex:
        """L'(s)/L(s) at s = jω; not finite on zeros and poles of the axis."""
        s = 1j * omega[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            parts = (1 / (s - self.zeros)).sum(axis=1) - (1 / (s - self.poles)).sum(axis=1)
        return np.asarray(parts)


def _finite(values: Real, bound: float) -> Real:
    """Values held within ±bound, nan included, at less cost than nan_to_num."""
    return np.asarray(np.fmax(np.fmin(values, bound), -bound))


def _order(roots: Complex, omega: float) -> int:
    """Power by which the factors of `roots` vanish at ω = 0, or fall at ω = inf."""
    return -roots.size if math.isinf(omega) else int(np.sum(roots == 0))


def _arguments(omega: Real, roots: Complex) -> Real:
    across = omega[:, None] - roots.imag
    angle = np.arctan2(across, abs(roots.real))
    return np.asarray(np.where(roots.real > 0, np.pi - angle, angle))


def _factor(system: Any) -> _Loop:
    split = _split_state_space if hasattr(system, "A") else _split_transfer_function
    zeros, poles, gain, closed, opposite, hidden = split(*_coefficients(system))
    excess = zeros.size - poles.size
    if excess == 0 and abs(1 + gain) <= _ILL_POSED:
        raise ValueError(
            f"1 + L(∞) = {1 + gain:.3g}: the loop is ill-posed, its closed loop has no finite "
            "gain; L(∞) other than −1 is accepted: model the roll-off of the loop, or change "
            "its gain"
        )
    power = _scale_power(np.concatenate([zeros, poles, closed]))
    scaled = [np.asarray(roots * 2.0**-power) for roots in (zeros, poles, closed, opposite)]
    zeros, poles = _snapped(scaled[0]), _snapped(scaled[1])
    gain = math.ldexp(gain, power * excess)
    return _Loop(zeros, poles, gain, scaled[2], scaled[3], hidden * 2.0**-power, 2.0**power)


def _scale_power(roots: Complex) -> int:
    """Power of two next to the geometric mean of |roots|: dividing by it rounds nothing."""
    size = abs(roots[roots != 0])
    return round(float(np.log2(size).mean())) if size.size else 0


def _snapped(roots: Complex) -> Complex:
    """Roots with those that rounding put beside the imaginary axis set on it."""
    return np.asarray(np.where(abs(roots.real) <= _AXIS * abs(roots), 1j * roots.imag, roots))


Split = tuple[Complex, Complex, float, Complex, Complex, Complex]


def _split_transfer_function(numerator: Real, denominator: Real) -> Split:
    roots = [
        np.roots(polynomial).astype(complex)
        for polynomial in (
            numerator,
            denominator,
            np.polyadd(denominator, numerator),
            np.polysub(denominator, numerator),
        )
    ]
    leading = [np.trim_zeros(part, "f")[:1] for part in (numerator, denominator)]
    gain = float(leading[0][0] / leading[1][0]) if leading[0].size else 0.0
    return roots[0], roots[1], gain, roots[2], roots[3], np.empty(0, complex)


def _split_state_space(a: Real, b: Real, c: Real, d: Real) -> Split:
    kept = _reached(a, b) & _reached(a.T, c)
    hidden = _eigenvalues(a[np.ix_(~kept, ~kept)])
    a, b, c = _balanced(a[np.ix_(kept, kept)], b[kept], c[kept], d)
    poles = _eigenvalues(a)
    zeros, gain = _refined((a, b, c, d), poles, *_invariant_zeros(a, b, c, d))
    closed, opposite = (_invariant_zeros(a, b, sign * c, 1 + sign * d)[0] for sign in (1, -1))
    return zeros, poles, gain, closed, opposite, hidden


def _refined(system: Any, poles: Complex, zeros: Complex, gain: float) -> tuple[Complex, float]:
    """Zeros after Newton steps on L(s) itself, and the gain that meets L at one point.

    Deflation loses digits where the states are badly scaled; solving (sI − A)x = B loses fewer.
    """
    if gain == 0 or not poles.size:
        return zeros, gain
    free = _apart(zeros, poles)
    moving = zeros[free]
    for _ in range(4):
        value, slope = _response(system, moving)
        with np.errstate(all="ignore"):
            trial = moving - value / slope
        trial = np.where(_apart(trial, poles), trial, moving)
        moving = np.where(abs(_response(system, trial)[0]) < abs(value), trial, moving)
    zeros = np.concatenate([moving, zeros[~free]])
    if system[-1] != 0:
        return zeros, gain
    point = np.array([2.0 ** _scale_power(poles) * np.exp(1j)])
    logs = np.log(point - poles).sum() - np.log(point - zeros).sum()
    return zeros, float((_response(system, point)[0] * np.exp(logs)).real[0])


def _apart(roots: Complex, poles: Complex) -> npt.NDArray[np.bool_]:
    """Mask of nonzero finite roots where L is finite: beside a pole that they cancel it is 0/0."""
    with np.errstate(invalid="ignore"):
        gaps = abs(roots[:, None] - poles).min(axis=1)
        return np.asarray((gaps > 1e-6 * abs(roots)) & (roots != 0))


def _response(system: Any, s: Complex) -> tuple[Complex, Complex]:
    """L(s) and L'(s)."""
    a, b, c, d = system
    shifted = s[:, None, None] * np.eye(b.size) - a
    states = np.linalg.solve(shifted, np.broadcast_to(b[:, None], (s.size, b.size, 1)))
    return states[..., 0] @ c + d, -(np.linalg.solve(shifted, states)[..., 0] @ c)


def _reached(a: Real, b: Real) -> npt.NDArray[np.bool_]:
    """Mask of the states that a chain of nonzero coefficients joins to the input."""
    reached = b != 0
    for _ in range(b.size):
        reached = reached | ((a != 0) @ reached)
    return np.asarray(reached)


def _balanced(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any, Any]:
    """Scale the states by powers of two so that rows and columns of [[A, B], [C, D]] match."""
    from scipy.linalg import matrix_balance

    if not a.size:
        return a, b, c
    whole = np.block([[a, b[:, None]], [c[None, :], d]])
    balanced, _ = matrix_balance(whole, permute=False)
    return balanced[:-1, :-1], balanced[:-1, -1], balanced[-1, :-1]


def _invariant_zeros(a: Any, b: Any, c: Any, d: Any) -> tuple[Complex, float]:
    """Return the zeros and high-frequency gain of (A, B, C, D), all infinite zeros deflated.

    While D = 0, zero output holds the state that C sees at zero; without it the output of the
    remaining system is that state's derivative. Emami-Naeini and Van Dooren, Automatica 18
    (1982) 415-430, for one input and output.
    """
    gain: Any = 1.0
    floor_c: Any = 0.0
    floor_d: Any = 0.0
    while abs(d) <= floor_d:
        if np.linalg.norm(c) <= floor_c:
            return np.empty(0, complex), 0.0
        turn = np.linalg.qr(c.conj()[:, None], mode="complete")[0]
        gain = gain * (c @ turn)[0]
        a, b = turn.conj().T @ a @ turn, turn.conj().T @ b
        floor_c, floor_d = 1e-13 * np.linalg.norm(a), 1e-13 * np.linalg.norm(b)
        a, b, c, d = a[1:, 1:], b[1:], a[0, 1:], b[0]
    return _eigenvalues(a - np.outer(b, c) / d), gain * d


def _eigenvalues(matrix: Any) -> Complex:
    """Eigenvalues, those at 0 exact: the null space is split off before the rest is solved."""
    at_zero, floor = 0, 0.0
    while matrix.size:
        rows = np.linalg.norm(matrix, axis=1, keepdims=True)
        scaled = np.where(rows > floor, matrix / np.where(rows > floor, rows, 1.0), 0.0)
        _, sizes, right = np.linalg.svd(scaled)
        # What a split leaves of a zero is rounding of the rows split, never a row of its own.
        floor = 8 * len(sizes) * np.finfo(float).eps
        rank = int(np.sum(sizes > floor * sizes[0]))
        if rank == len(sizes):
            break
        at_zero += len(sizes) - rank
        floor *= np.linalg.norm(matrix)
        matrix = (right @ matrix @ right.conj().T)[:rank, :rank]
    return np.concatenate([np.linalg.eigvals(matrix), np.zeros(at_zero)]).astype(complex)


def _is_stable(poles: Complex) -> bool:
    return bool(np.all(-poles.real > DAMPING_FLOOR * abs(poles)))


def _stationary(zeros: Complex, poles: Complex, *, of_phase: bool = False) -> Real:
    """Every ω > 0 where ln |Π(jω − z)/Π(jω − p)|, or its phase, may have zero slope."""
    roots = np.concatenate([zeros, poles])
    signs = np.concatenate([np.ones(zeros.size), -np.ones(poles.size)])
    squares = _secular_roots(-(roots**2), signs * roots if of_phase else signs.astype(complex))
    squares = squares[squares.real > 0]
    return np.unique(np.sqrt(squares.real))


def _secular_roots(places: Complex, weights: Complex) -> Complex:
    """Roots x of Σ wᵢ/(x − xᵢ) = 0, and iterates that run away where roots are infinite."""
    places, weights = _merged(places, weights) if places.size else (places, weights)
    if places.size < 2:
        return np.empty(0, complex)
    apart = abs(places[:, None] - places)
    np.fill_diagonal(apart, np.inf)
    # Off each place by a share of the gap to the next, turned to break every symmetry.
    start = places + 0.5 * apart.min(axis=1) * np.exp(1j)
    return _aberth(np.delete(start, abs(places).argmax()), places, weights)


def _merged(places: Complex, weights: Complex) -> tuple[Complex, Complex]:
    """Sum the weights of coinciding places, and drop what cancels."""
    same = abs(places[:, None] - places) <= 1e-14 * abs(places)
    first = same.argmax(axis=1)
    kept = np.unique(first)
    total = np.array([weights[first == i].sum() for i in kept], dtype=complex)
    bulk = np.array([abs(weights[first == i]).sum() for i in kept])
    some = abs(total) > 1e-14 * bulk
    return places[kept][some], total[some]


def _aberth(x: Complex, places: Complex, weights: Complex) -> Complex:
    """Refine all roots of Σ wᵢ/(x − xᵢ) at once by Aberth's iteration."""
    for _ in range(100):
        with np.errstate(all="ignore"):
            near = 1 / (x[:, None] - places)
            ratio = near.sum(axis=1) - (near**2 @ weights) / (near @ weights)
            gaps = x[:, None] - x
            np.fill_diagonal(gaps, np.inf)
            step = 1 / (ratio - (1 / gaps).sum(axis=1))
        step = np.where(np.isfinite(step), step, 0)
        x = x - step
        if np.all(abs(step) <= 1e-15 * abs(x)):
            break
    return x


Function = Callable[[Real], Real]


def _crossings(function: Function, points: Real) -> list[float]:
    """Roots between ascending `points`, one per sign change, and points that touch 0."""
    values = function(points)
    sides = np.sign(values)
    touching = (abs(values[1:-1]) <= TOUCH_TOLERANCE) & (sides[:-2] == sides[2:])
    sides[1:-1][touching] = 0
    changes = np.flatnonzero(sides[:-1] * sides[1:] < 0)
    roots = [_root_between(function, *points[i : i + 2]) for i in changes]
    return sorted(roots + points[sides == 0].tolist())


def _root_between(function: Function, low: float, high: float) -> float:
    from scipy.optimize import brentq

    def at(exponent: float) -> float:
        return float(function(np.exp([exponent]))[0])

    sides = np.sign(function(np.array([low, high])))
    # exp(log(x)) rounds, and may step over a root that lies beside an end.
    for end, side in zip((low, high), sides, strict=True):
        if at(math.log(end)) * side <= 0:
            return float(end)
    return math.exp(brentq(at, math.log(low), math.log(high), xtol=1e-16, rtol=1e-15))


def _extended(function: Function, points: Real, start: float, end: float) -> Real:
    """Points with one more on either side, as far out as the limit's sign asks for."""
    if not points.size:
        points = np.ones(1)
    reach = 2.0 ** (2.0 ** np.arange(0, 9.25, 0.25))
    low = _agreeing(function, points[0] / reach, start)
    high = _agreeing(function, points[-1] * reach, end)
    return np.concatenate([[low], points, [high]])


def _agreeing(function: Function, outward: Real, limit: float) -> float:
    """First of the points `outward` at which the function has the sign of its limit."""
    # A limit on the level itself is a touch there, and signs beside it are rounding.
    if abs(limit) <= TOUCH_TOLERANCE:
        return float(outward[0])
    return float(outward[np.argmax(np.sign(function(outward)) == np.sign(limit))])


def _level_crossings(function: Function, points: Real, start: float, end: float) -> list[float]:
    return _crossings(function, _extended(function, points, start, end))


def _gain_crossings(loop: _Loop) -> list[float]:
    """All ω with |L(jω)| = 1, the limits 0 and inf included."""
    if loop.gain == 0:
        return []
    limits = {omega: _log(abs(loop.limit(omega))) for omega in (0.0, math.inf)}
    points = _stationary(loop.zeros, loop.poles)
    inner = _level_crossings(loop.log_gain, points, limits[0.0], limits[math.inf])
    at_limits = [omega for omega in limits if abs(limits[omega]) <= TOUCH_TOLERANCE]
    return sorted(inner + at_limits)


def _log(size: float) -> float:
    return math.log(size) if size > 0 else -math.inf


def _phase_crossings(loop: _Loop) -> list[float]:
    """All ω where L(jω) is finite, real and negative, the limits 0 and inf included."""
    if loop.gain == 0:
        return []
    axis = np.concatenate([loop.zeros, loop.poles])
    axis = axis[(axis.real == 0) & (axis.imag > 0)].imag
    points = _stationary(loop.zeros, loop.poles, of_phase=True)
    points = np.unique(np.concatenate([points, axis * (1 - 1e-9), axis * (1 + 1e-9)]))
    inner = [
        root for target in _targets(loop, points) for root in _phase_hits(loop, points, target)
    ]
    # On a zero or pole on the axis the phase jumps across the target; L is 0 or unbounded there.
    inner = [root for root in inner if not np.any(abs(root - axis) <= 2e-9 * axis)]
    at_limits = [omega for omega in (0.0, math.inf) if -math.inf < loop.limit(omega) < 0]
    return sorted(inner + at_limits)


def _targets(loop: _Loop, points: Real) -> Real:
    """Odd multiples of π within the range of the phase."""
    limits = [loop.phase_limit(0.0), loop.phase_limit(math.inf)]
    phases = np.concatenate([limits, loop.phase(points)])
    turns = np.arange(np.floor(phases.min() / np.pi) - 1, np.ceil(phases.max() / np.pi) + 2)
    return np.asarray(np.pi * turns[turns % 2 == 1])


def _phase_hits(loop: _Loop, points: Real, target: float) -> list[float]:
    start, end = (loop.phase_limit(omega) - target for omega in (0.0, math.inf))
    return _level_crossings(lambda omega: loop.phase(omega) - target, points, start, end)


class _Shape(NamedTuple):
    """A function F of L with its logarithmic derivative L·F'(L)/F(L)."""

    value: Callable[[Any], Any]
    sensitivity: Callable[[Any], Any]


_S = _Shape(lambda x: 1 / (1 + x), lambda x: -x / (1 + x))
_T = _Shape(lambda x: x / (1 + x), lambda x: 1 / (1 + x))
_DISK = _Shape(lambda x: (1 - x) / (1 + x), lambda x: -2 / (1 + x) * (x / (1 - x)))


def _margins(
    loop: _Loop, crossovers: list[float], phase_crossovers: list[float]
) -> dict[str, float]:
    """Every margin of a stable loop, by field name."""
    peak_s, at_s = _peak(loop, _S, loop.poles)
    peak_t, at_t = _peak(loop, _T, loop.zeros)
    peak_d, at_d = _peak(loop, _DISK, loop.opposite)
    return {
        **_phase_and_delay(loop, crossovers),
        **_gain_margins(loop, phase_crossovers),
        "modulus_margin": 1 / peak_s,
        "modulus_margin_hz": loop.hertz(at_s),
        "disk_margin": 2 / peak_d if peak_d else math.inf,
        "disk_margin_hz": loop.hertz(at_d),
        "sensitivity_peak": peak_s,
        "sensitivity_peak_hz": loop.hertz(at_s),
        "complementary_peak": peak_t,
        "complementary_peak_hz": loop.hertz(at_t),
        "bandwidth_hz": _bandwidth(loop),
    }


def _phase_and_delay(loop: _Loop, crossovers: list[float]) -> dict[str, float]:
    values = np.array([loop.value(omega) for omega in crossovers], dtype=complex)
    delay, at_delay = _delay_margin(loop, crossovers, np.angle(-values) % (2 * np.pi))
    found = {"delay_margin_s": delay / loop.scale, "delay_margin_hz": loop.hertz(at_delay)}
    if not crossovers:
        return {**found, "phase_margin_deg": math.inf}
    angles = abs(np.angle(-values, deg=True))
    nearest = int(angles.argmin())
    angle, crossover = float(angles[nearest]), loop.hertz(crossovers[nearest])
    return {**found, "phase_margin_deg": angle, "crossover_hz": crossover}


def _delay_margin(loop: _Loop, crossovers: list[float], lags: Real) -> tuple[float, float]:
    if abs(loop.limit(math.inf)) >= 1 - TOUCH_TOLERANCE:
        return 0.0, math.inf
    delays = [
        (float(lag / omega), omega) for lag, omega in zip(lags, crossovers, strict=True) if omega
    ]
    return min(delays, default=(math.inf, math.nan))


def _gain_margins(loop: _Loop, phase_crossovers: list[float]) -> dict[str, float]:
    sizes = [(20 * math.log10(abs(loop.value(omega))), omega) for omega in phase_crossovers]
    none = (math.inf, math.nan)
    lower, at_lower = min((pair for pair in sizes if pair[0] > 0), default=none)
    upper, at_upper = min(((-size, omega) for size, omega in sizes if size < 0), default=none)
    return {
        "lower_gain_margin_db": lower,
        "lower_gain_margin_hz": loop.hertz(at_lower),
        "upper_gain_margin_db": upper,
        "upper_gain_margin_hz": loop.hertz(at_upper),
    }


def _peak(loop: _Loop, shape: _Shape, zeros: Complex) -> tuple[float, float]:
    """Return max |F(L(jω))| over 0 ≤ ω ≤ ∞ and where; `zeros` are those of F(L(s))."""

    def slope(omega: Real) -> Real:
        with np.errstate(all="ignore"):
            product = loop.log_derivative(omega) * shape.sensitivity(loop.values(omega))
        return _finite(-product.imag, _HUGE)

    points = _surrounded(_stationary(zeros, loop.closed))
    sides = np.sign(slope(points))
    tops = np.flatnonzero((sides[:-1] >= 0) & (sides[1:] < 0))
    places = [0.0, *(_root_between(slope, *points[i : i + 2]) for i in tops), math.inf]
    sizes = np.array([abs(shape.value(loop.value(omega))) for omega in places])
    # Of equal peaks the lowest in frequency, so that rounding does not choose.
    best = int(np.argmax(sizes >= sizes.max() * (1 - 1e-14)))
    return float(sizes[best]), places[best]


def _surrounded(points: Real) -> Real:
    """Points with their geometric means between them, and one beyond each end."""
    if not points.size:
        return points
    ends = np.concatenate([points[:1] / 2, points, points[-1:] * 2])
    return np.unique(np.concatenate([ends, np.sqrt(ends[:-1] * ends[1:])]))


def _bandwidth(loop: _Loop) -> float:
    at_dc, at_infinity = (abs(_T.value(loop.value(omega))) for omega in (0.0, math.inf))
    if at_dc == 0:
        return math.nan
    level = math.log(at_dc) - math.log(2) / 2

    def excess(omega: Real) -> Real:
        return np.asarray(loop.log_gain(omega) - np.log(abs(1 + loop.values(omega))) - level)

    points = _stationary(loop.zeros, loop.closed)
    falls = _level_crossings(excess, points, math.log(2) / 2, _log(at_infinity) - level)
    return loop.hertz(falls[0]) if falls else math.nan
