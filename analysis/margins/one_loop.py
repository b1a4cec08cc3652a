"""Stability margins of a single-input, single-output negative-feedback loop."""

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from .crossings import (
    TOUCH_TOLERANCE,
    gain_crossings,
    level_crossings,
    phase_crossings,
    stationary_points,
)
from .factored_loop import (
    HIGHEST,
    LOWEST,
    Complex,
    FactoredLoop,
    Real,
    factored,
    is_stable,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    import control


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
        return "\n".join(["stable", *(_line(*row) for row in self.rows())])

    def rows(self) -> list[tuple[str, float, str, float]]:
        """Return (name, value, unit, frequency in Hz or nan) of each margin, for a table."""
        return [
            ("phase margin", self.phase_margin_deg, "deg", self.crossover_hz),
            ("lower gain margin", self.lower_gain_margin_db, "dB", self.lower_gain_margin_hz),
            ("upper gain margin", self.upper_gain_margin_db, "dB", self.upper_gain_margin_hz),
            ("delay margin", self.delay_margin_s, "s", self.delay_margin_hz),
            ("modulus margin", self.modulus_margin, "", self.modulus_margin_hz),
            ("disk margin", self.disk_margin, "", self.disk_margin_hz),
            ("peak of S", self.sensitivity_peak, "", self.sensitivity_peak_hz),
            ("peak of T", self.complementary_peak, "", self.complementary_peak_hz),
            ("bandwidth", self.bandwidth_hz, "Hz", math.nan),
        ]

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
    Well-conditioned loops come out to about 1e-12 relative, whatever the unit of time, but for
    the places of the peaks: a smooth maximum leaves its frequency eight digits, at worst. An
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
    loop = factored(system)
    poles = loop.closed_loop_poles()
    crossovers, phase_crossovers = gain_crossings(loop), phase_crossings(loop)
    stable = is_stable(poles)
    margins = _margins(loop, crossovers, phase_crossovers) if stable else {}
    return LoopMargins(
        stable=stable,
        closed_loop_poles=poles,
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


def _line(name: str, value: float, unit: str, hz: float) -> str:
    shown = "none" if math.isnan(value) else f"{value:.4g} {unit}".strip()
    place = "" if math.isnan(hz) else " as f → ∞" if math.isinf(hz) else f" at {hz:.4g} Hz"
    return f"{name:<18} {shown:>12}{place}"


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


def _sensitivity(loop: Complex) -> Complex:
    return np.asarray(1 / (1 + loop))


def _complementary(loop: Complex) -> Complex:
    return np.asarray(loop / (1 + loop))


def _disk(loop: Complex) -> Complex:
    return np.asarray((1 - loop) / (1 + loop))


def _margins(
    loop: FactoredLoop, crossovers: list[float], phase_crossovers: list[float]
) -> dict[str, float]:
    """Every margin of a stable loop, by field name."""
    peak_s, at_s = _peak(loop, _sensitivity, loop.poles)
    peak_t, at_t = _peak(loop, _complementary, loop.zeros)
    peak_d, at_d = _peak(loop, _disk, loop.opposite)
    return {
        **_phase_and_delay(loop, np.array(crossovers)),
        **_gain_margins(loop, np.array(phase_crossovers)),
        "modulus_margin": 1 / peak_s,
        "modulus_margin_hz": at_s,
        "disk_margin": 2 / peak_d if peak_d else math.inf,
        "disk_margin_hz": at_d,
        "sensitivity_peak": peak_s,
        "sensitivity_peak_hz": at_s,
        "complementary_peak": peak_t,
        "complementary_peak_hz": at_t,
        "bandwidth_hz": _bandwidth(loop),
    }


def _phase_and_delay(loop: FactoredLoop, crossovers: Real) -> dict[str, float]:
    angles = np.angle(-loop.values(crossovers))
    delays = np.where(crossovers > LOWEST, angles % (2 * np.pi) / crossovers, math.inf)
    delay, at_delay = _least(delays, crossovers)
    if loop.log_gain(np.array([HIGHEST]))[0] >= -TOUCH_TOLERANCE:
        delay, at_delay = 0.0, HIGHEST
    angle, crossover = _least(abs(angles), crossovers)
    return {
        "delay_margin_s": delay / loop.scale,
        "delay_margin_hz": loop.hertz(at_delay),
        "phase_margin_deg": math.degrees(angle),
        "crossover_hz": loop.hertz(crossover),
    }


def _gain_margins(loop: FactoredLoop, crossovers: Real) -> dict[str, float]:
    sizes = loop.log_gain(crossovers) * (20 / math.log(10))
    lower, at_lower = _least(sizes[sizes > 0], crossovers[sizes > 0])
    upper, at_upper = _least(-sizes[sizes < 0], crossovers[sizes < 0])
    return {
        "lower_gain_margin_db": lower,
        "lower_gain_margin_hz": loop.hertz(at_lower),
        "upper_gain_margin_db": upper,
        "upper_gain_margin_hz": loop.hertz(at_upper),
    }


def _least(margins: Real, places: Real) -> tuple[float, float]:
    """Return the smallest finite margin and where it is taken."""
    if not np.isfinite(margins).any():
        return math.inf, math.nan
    return float(margins.min()), float(places[margins.argmin()])


def _peak(
    loop: FactoredLoop, shape: "Callable[[Complex], Complex]", zeros: Complex
) -> tuple[float, float]:
    """Return max |F(L(jω))| over all ω and where, in Hz; `zeros` are those of F(L(s))."""
    inner = stationary_points(zeros, loop.closed)
    places = np.concatenate([[LOWEST], inner, [HIGHEST]])
    sizes = abs(shape(loop.values(places)))
    # Of equal peaks the lowest in frequency, so that rounding does not choose.
    best = int(np.argmax(sizes >= sizes.max() * (1 - 1e-14)))
    return float(sizes[best]), loop.hertz(float(places[best]))


def _bandwidth(loop: FactoredLoop) -> float:
    at_dc = abs(_complementary(loop.values(np.array([LOWEST]))))[0]
    if at_dc < math.sqrt(LOWEST):
        return math.nan
    level = math.log(at_dc) - math.log(2) / 2

    def excess(omega: Real) -> Real:
        return np.asarray(loop.log_gain(omega) - np.log(abs(1 + loop.values(omega))) - level)

    falls = level_crossings(excess, stationary_points(loop.zeros, loop.closed))
    return loop.hertz(falls[0]) if falls else math.nan
