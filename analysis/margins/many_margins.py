"""Stability margins of many loops at once, rational ones with a delay, on arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from ...plant import PID, Inertia
from ...shaping.checks import of_kind
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.told import Rows, Told, fields_of
from ...shaping.trajectory_checks import finite_array
from .factored_loop import DAMPING_FLOOR, Real
from .many_crossings import pieces_of, stable
from .many_gain_and_phase import gain_margins, phase_and_delay
from .many_loops import Mask, loops_of
from .many_modulus import modulus
from .many_roots import roots, trimmed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CHUNK = 4096  # loops whose arrays stay in the processor's cache


@dataclass(frozen=True, eq=False, repr=False)
class ManyMargins(Told, Frozen):
    """Margins of many negative-feedback loops, arrays of one shape, read-only.

    As in `LoopMargins`: what nothing limits is inf, and its frequency nan; a frequency is 0 or
    inf where the value is a limit; all margins of an unstable loop are nan. Indexing gives the
    margins of some of the loops.

    Attributes
    ----------
    stable : array of bool
    crossover_hz : array
        Gain crossover where the phase margin is taken.
    phase_margin_deg : array
        Smallest angle, in either direction, from L to −1 over all crossovers.
    lower_gain_margin_db, upper_gain_margin_db : array
        How far the gain may fall, and rise, before the loop is unstable; both positive.
    lower_gain_margin_hz, upper_gain_margin_hz : array
        Where L is real and negative at those gains.
    delay_margin_s, delay_margin_hz : array
        Smallest added delay that destabilises, and its crossover.
    modulus_margin, modulus_margin_hz : array
        min |1 + L|, the distance from −1.
    """

    stable: Mask
    crossover_hz: Real
    phase_margin_deg: Real
    lower_gain_margin_db: Real
    lower_gain_margin_hz: Real
    upper_gain_margin_db: Real
    upper_gain_margin_hz: Real
    delay_margin_s: Real
    delay_margin_hz: Real
    modulus_margin: Real
    modulus_margin_hz: Real

    def __post_init__(self) -> None:
        for field in fields(self):
            array = np.asarray(getattr(self, field.name)).view()
            array.flags.writeable = False
            object.__setattr__(self, field.name, array)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of every array."""
        return self.stable.shape

    def __getitem__(self, index: Any) -> ManyMargins:
        """Return the margins of some of the loops."""
        return ManyMargins(*(getattr(self, field.name)[index] for field in fields(self)))

    def table_rows(self) -> Rows:
        """Return how many are stable, and the range of each margin over those."""
        yield "shape", str(self.shape)
        yield "stable", f"{int(np.count_nonzero(self.stable))} of {self.stable.size}"
        for name, values in fields_of(self):
            known = values[np.isfinite(values)] if name != "stable" else np.empty(0)
            if known.size:
                yield name, f"{known.min():.5g} … {known.max():.5g}"

    def __repr__(self) -> str:
        return f"ManyMargins(shape={self.shape}, stable={int(np.count_nonzero(self.stable))})"

    def plot(
        self,
        x: ArrayLike,
        y: ArrayLike,
        *,
        margin: str = "phase_margin_deg",
        ax: Axes | None = None,
        levels: Sequence[float] | None = None,
        xlabel: str = "",
        ylabel: str = "",
    ) -> Axes:
        """Draw the contours of a margin over a plane of loops, unstable ones hatched.

        Parameters
        ----------
        x, y : (N,) and (M,) arrays
            What varies along the last and the first axis of the margins, of shape (M, N).
        margin : str, optional
            Name of the margin.
        ax : Axes, optional
            Default: pyplot's current ones.
        levels : sequence of float, optional
            Of the contours; default: chosen to fit.
        xlabel, ylabel : str, optional
            With units.
        """
        drawn: Axes = draw(
            self, ax, x=x, y=y, margin=margin, levels=levels, xlabel=xlabel, ylabel=ylabel
        )
        return drawn


def many_loop_margins(
    numerator: ArrayLike, denominator: ArrayLike, *, delay: ArrayLike = 0.0
) -> ManyMargins:
    """Return the margins of many unity negative-feedback loops: `loop_margins` on arrays.

        L(s) = N(s)/D(s)·e^(−s·delay)

    The delay is not approximated. The three arguments are broadcast against one another.

    Parameters
    ----------
    numerator, denominator : (..., m + 1) and (..., n + 1) arrays
        Real coefficients of N and D, the highest power first, as in python-control; zeros in
        front are dropped. Continuous time, in rad/s. Improper loops are accepted.
    delay : (...) array, optional
        In seconds, zero or positive.

    Returns
    -------
    ManyMargins
        With arrays of the broadcast shape. Frequencies in Hz, gains in dB, angles in degrees,
        delays in seconds.

    Raises
    ------
    TypeError
        For complex coefficients.
    ValueError
        For arrays that do not fit or are not finite, a denominator that is zero, or a negative
        delay. Unstable loops raise nothing, nor do ill-posed ones, L(∞) = −1: they are unstable.

    Notes
    -----
    Nothing is searched for on a grid. Roots of polynomials in ω² cut the frequency axis where
    gain or phase turn; each piece is searched for the crossing that it can hold, on L(jω) itself.
    Stability is Nyquist's criterion, counted from the phases at the gain crossovers, so that a
    long delay costs no more than a short one. A loop whose phase margin is below 1e-10 rad
    counts as unstable.

    Margins of well-conditioned loops agree with `loop_margins` to 1e-9 relative, mostly to 1e-12.
    A delay that turns the phase n times by the crossover costs it log10(n) digits. The modulus
    margin is found by branch and bound: nowhere is |1 + L| smaller by more than 10 %, by bounds
    that hold but for rounding, and the minimum itself is solved for to rounding. Roots nearer to
    the axis than a damping ratio of 1e-13 count as undamped.

    A PID on an inertia takes about 30 µs, a loop of order 8 some 0.15 ms; memory beside the
    results stays below 100 MB.

    References
    ----------
    H. Nyquist, "Regeneration theory", Bell System Technical Journal 11 (1932) 126-147.

    Examples
    --------
    >>> margins = many_loop_margins([1.0], [1.0, 1.0, 0.0], delay=[0.0, 0.5, 2.0])
    >>> margins.phase_margin_deg.round(3)
    array([51.827, 29.306,    nan])
    """
    num, den = _coefficients("numerator", numerator), _coefficients("denominator", denominator)
    delays = _delays(delay)
    shapes = num.shape[:-1], den.shape[:-1], delays.shape
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(
            f"numerators of shape {shapes[0]}, denominators of {shapes[1]} and delays of "
            f"{shapes[2]} do not fit: expected shapes that broadcast, coefficients on a last axis"
        ) from None
    _check_denominator(den)
    return _margins(
        np.broadcast_to(num, (*shape, num.shape[-1])),
        np.broadcast_to(den, (*shape, den.shape[-1])),
        np.broadcast_to(delays, shape)[..., None],
    )


def servo_margins(
    inertia: Inertia | ArrayLike, controller: PID, *, gain: ArrayLike = 1.0, delay: ArrayLike = 0.0
) -> ManyMargins:
    """Return the margins of one PID on many inertias, at many gains and delays.

        L(s) = gain·(kr·s² + kp·s + ki)/(J·s³)·e^(−s·delay)

    Parameters
    ----------
    inertia : Inertia or array
        J, positive.
    controller : PID
    gain : array, optional
        By which the whole loop's gain is multiplied.
    delay : array, optional
        In seconds, zero or positive.

    Returns
    -------
    ManyMargins
        Of the shape that `inertia`, `gain` and `delay` broadcast to.

    Raises
    ------
    TypeError
        If `controller` is not a PID.
    ValueError
        For an inertia that is not positive, or as `many_loop_margins` does.

    Examples
    --------
    >>> from jounce.plant import design_pid
    >>> pid = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
    >>> margins = servo_margins([[0.5], [1.0], [2.0]], pid, delay=[0.0, 0.05])
    >>> margins.phase_margin_deg.round(1)
    array([[64.3, 31.8],
           [45. , 27. ],
           [21.8, 10.7]])
    """
    of_kind("controller", controller, PID, "a PID")
    given = inertia.J if isinstance(inertia, Inertia) else inertia
    moments, gains = finite_array("inertia", given), finite_array("gain", gain)
    _refuse("inertia", moments, moments <= 0.0, "expected positive inertias")
    rates = [controller.kr, controller.kp, controller.ki]
    powers = [1.0, 0.0, 0.0, 0.0]
    if controller.ki == 0.0:
        rates, powers = rates[:-1], powers[:-1]
    return many_loop_margins(
        gains[..., None] * np.array(rates), moments[..., None] * np.array(powers), delay=delay
    )


def _coefficients(name: str, given: ArrayLike) -> Real:
    rows = np.atleast_1d(finite_array(name, given))
    if not rows.shape[-1]:
        raise ValueError(f"{name} of shape {rows.shape} has no coefficients along its last axis")
    return rows


def _delays(delay: ArrayLike) -> Real:
    delays = finite_array("delay", delay)
    _refuse("delay", delays, delays < 0.0, "expected delays of zero or more")
    return delays


def _check_denominator(rows: Real) -> None:
    zero = ~rows.any(axis=-1)
    if zero.any():
        where = ", ".join(str(i) for i in np.argwhere(zero)[0])
        element = f"denominator[{where}]" if where else "denominator"
        raise ValueError(
            f"{element} = {rows[zero][0].tolist()}: expected a polynomial other than 0"
        )


def _refuse(name: str, values: Real, wrong: npt.NDArray[np.bool_], expected: str) -> None:
    if wrong.any():
        place = tuple(np.argwhere(wrong)[0])
        where = f"[{', '.join(str(i) for i in place)}]" if place else ""
        raise ValueError(f"{name}{where} = {values[place]}: {expected}")


def _margins(numerator: Real, denominator: Real, delay: Real) -> ManyMargins:
    """Return the margins of loops of one shape, a chunk at a time."""
    shape = delay.shape[:-1]
    count = int(np.prod(shape))
    good = np.zeros(count, dtype=bool)
    found = {field.name: np.full(count, np.nan) for field in fields(ManyMargins)[1:]}
    with np.errstate(all="ignore"):
        for i in range(0, count, _CHUNK):
            some = np.arange(i, min(i + _CHUNK, count))
            index = np.unravel_index(some, shape) if shape else np.newaxis
            _put(good, found, some, *(part[index] for part in (numerator, denominator, delay)))
    arrays = {name: values.reshape(shape) for name, values in found.items()}
    return ManyMargins(stable=good.reshape(shape), **arrays)


def _put(
    good: Mask, found: dict[str, Real], some: Any, numerator: Real, denominator: Real, delay: Real
) -> None:
    """Put the margins of some loops in place."""
    silent = ~numerator.any(axis=1)
    _put_silent(good, found, some[silent], denominator[silent])
    some, num, den, delay = (part[~silent] for part in (some, numerator, denominator, delay))
    pieces = pieces_of(loops_of(num, den, delay[:, 0]))
    good[some] = kept = stable(pieces)
    some, pieces = some[kept], pieces.take(kept)
    if not some.size:
        return
    margins, crossings = gain_margins(pieces)
    margins |= phase_and_delay(pieces)
    margins["modulus_margin"], margins["modulus_margin_hz"] = modulus(pieces, crossings)
    scale = pieces.loops.scale
    units = {"hz": scale / (2.0 * np.pi), "s": 1.0 / scale}
    for name, values in margins.items():
        found[name][some] = values * units.get(name.rsplit("_", 1)[1], 1.0)


def _put_silent(good: Mask, found: dict[str, Real], some: Any, denominator: Real) -> None:
    """Put the margins of loops in place that have no gain at all."""
    rows, integrators = trimmed(denominator[:, ::-1])
    poles = roots(rows)
    damped = (-poles.real > DAMPING_FLOOR * abs(poles)) | ~np.isfinite(poles)
    good[some] = kept = damped.all(axis=1) & (integrators == 0)
    some = some[kept]
    for name in ("phase_margin_deg", "lower_gain_margin_db", "upper_gain_margin_db"):
        found[name][some] = np.inf
    found["delay_margin_s"][some] = np.inf
    found["modulus_margin"][some], found["modulus_margin_hz"][some] = 1.0, 0.0
