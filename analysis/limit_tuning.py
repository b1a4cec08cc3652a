"""The limits, or the input shaper, with which the load of a loop settles soonest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plant import ServoLoop, as_axis, design_pid, low_frequency_feedforward
from ..shaping import InputShaper, Limits, Trajectory, input_shaper, min_time_move
from ..shaping.checks import finite, one_of, positive
from ..shaping.drawing import draw
from ..shaping.frozen import Frozen
from ..shaping.real_numbers import shown
from ..shaping.told import Told
from .limit_trials import Bench, Family, LimitTrial
from .margins import loop_margins

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..plant.axis import Axis

_RAMPS = 16  # of acceleration, over the times that are tried
_SHARES = (0.06, 0.12, 0.25, 0.5, 1.0)  # of such a ramp in which jerk rises
_ROUNDS = 3  # about the best of each family, each three times as fine
_FINALISTS = 20
_LIGHT = 0.3  # damping below which a mode rings


@dataclass(frozen=True, eq=False, repr=False)
class TunedLimits(Told, Frozen):
    """The move that settled soonest, and all that were tried.

    Attributes
    ----------
    limits : Limits
        Of the move.
    shaper : InputShaper or None
        Behind it.
    best : LimitTrial
        Its settling is exact in continuous time.
    trials : tuple of LimitTrial
        Settling seen on a grid, in the order in which they were tried.
    loop : ServoLoop
    distance, settle_to : float
    """

    limits: Limits
    shaper: InputShaper | None
    best: LimitTrial
    trials: tuple[LimitTrial, ...]
    loop: ServoLoop
    distance: float
    settle_to: float

    @property
    def move(self) -> Trajectory:
        """The command that settled soonest."""
        move = min_time_move(self.distance, self.limits, method="closed-form")
        return move if self.shaper is None else self.shaper.shape(move)

    @property
    def settling_time(self) -> float:
        """Time from the start after which the load stays within `settle_to`."""
        return self.best.settling_time

    @property
    def families(self) -> tuple[str, ...]:
        """What was tried: bounds on jerk, on snap, too, and shapers."""
        return tuple(dict.fromkeys(trial.family for trial in self.trials))

    def trade_off(self, family: str | None = None) -> tuple[LimitTrial, ...]:
        """Return the trials that none beats in both settling and peak torque, soonest first."""
        front: list[LimitTrial] = []
        chosen = [t for t in self.trials if family in (None, t.family)]
        for trial in sorted(chosen, key=lambda t: (t.settling_time, t.peak_torque)):
            if trial.settling_time < inf and (
                not front or trial.peak_torque < front[-1].peak_torque
            ):
                front.append(trial)
        return tuple(front)

    def plot(self) -> Figure:
        """Draw settling over the bound on jerk, and over peak torque, of all families."""
        figure: Figure = draw(self)
        return figure

    def __str__(self) -> str:
        best = self.best
        snap = f", snap {best.snap:.6g}" if best.order == 4 else ""
        shaper = f", {best.shaper}" if best.shaper else ""
        return (
            f"settles in {best.settling_time:.6g} with jerk {best.jerk:.6g}{snap}{shaper}: "
            f"move of {best.duration:.6g}, peak torque {best.peak_torque:.6g}; "
            f"{len(self.trials)} tried"
        )


def tune_limits(
    plant: Any,
    distance: float,
    *,
    settle_to: float,
    velocity: float = inf,
    acceleration: float | None = None,
    orders: Sequence[int] = (3, 4),
    shapers: Sequence[str] = ("ZV", "ZVD", "EI"),
    modes: Sequence[tuple[float, float]] | None = None,
) -> TunedLimits:
    """Return the limits, or the input shaper, with which the load settles soonest.

    A search: settling jumps by half a period of the mode wherever one more swing fits into the
    tolerance, so that no slope leads to the best. A grid of bounds on jerk, and on snap, of moves
    with and without shaper, is simulated in the loop, then three finer ones about the best of
    each; the best few of all are simulated again, exactly and for longer. What is returned is the
    best that was tried.

    Parameters
    ----------
    plant : ServoLoop, or Axis, FlexibleInertia, …
        An axis alone gets a PID with a crossover of a sixth of its lowest frequency with the motor
        held, and `low_frequency_feedforward`.
    distance : float
        Signed, not 0.
    settle_to : float
        Tolerance of the load's position, positive.
    velocity, acceleration : float, optional
        Bounds. Acceleration may be left out where the axis has a torque limit: it is then what 80 %
        of that gives. Of moves that reach the torque limit none is chosen.
    orders : sequence of 3 and 4, optional
        What is bounded: jerk, or jerk and snap. Feedforward of derivatives that the command lacks
        is left out.
    shapers : sequence of str, optional
        Kinds of input shaper tried, too; empty for none.
    modes : sequence of (frequency_hz, damping), optional
        What they null. Default: the poles of a continuous closed loop that ring most, of others
        the lowest mode with the motor held.

    Returns
    -------
    TunedLimits

    Raises
    ------
    ValueError
        For a value out of range, an unstable loop, or where no move settles within six times the
        time of the fastest one and four periods at crossover.

    Examples
    --------
    >>> from jounce.plant import PID, FlexibleInertia, InertiaFeedforward
    >>> axis = FlexibleInertia(2.0, 20.0, 0.01, load_fraction=0.4)
    >>> loop = ServoLoop(axis, PID(800.0, 2e3, 60.0), InertiaFeedforward(2.0))
    >>> tuned = tune_limits(loop, 0.1, settle_to=1e-5, acceleration=10.0, shapers=())
    >>> tuned.settling_time < 0.5
    True
    """
    bench = _bench(plant, distance, settle_to, velocity, acceleration, modes)
    families = _families(orders, shapers, bench)
    trials: list[LimitTrial] = []
    for family in families:
        trials += _searched(bench, family)
    best = _best(bench, trials)
    if best is None or best.settling_time == inf:
        raise _never(bench, trials)
    family = Family(best.order, best.shaper)
    return TunedLimits(
        bench.limits(family, bench.acceleration / best.jerk, _share(bench, best)),
        _shaper(bench, best.shaper),
        best,
        tuple(trials),
        bench.loop_for(best.order),
        bench.distance,
        bench.tolerance,
    )


def _bench(
    plant: Any,
    distance: float,
    settle_to: float,
    velocity: float,
    acceleration: float | None,
    modes: Sequence[tuple[float, float]] | None,
) -> Bench:
    loop = plant if isinstance(plant, ServoLoop) else _loop_of(plant)
    distance, tolerance = finite("distance", distance), positive("settle_to", settle_to)
    if distance == 0.0:
        raise ValueError("distance = 0.0: a move that goes nowhere settles at once; give another")
    if tolerance >= abs(distance):
        raise ValueError(
            f"settle_to = {shown(settle_to)} is not below the distance, "
            f"{shown(distance)}: give the "
            "tolerance about the end"
        )
    speed = velocity if velocity == inf else positive("velocity", velocity)
    push = _acceleration(loop.axis, acceleration)
    margins = loop_margins(loop.loop_transfer())
    if not margins.stable:
        raise ValueError("the loop is unstable: tune its gains first, by design_pid or tune_pid")
    fastest = min_time_move(distance, Limits(speed if speed < inf else None, push)).duration
    slowest = 4.0 / margins.crossover_hz if 0.0 < margins.crossover_hz < inf else 0.0
    found = _ringing(loop) if modes is None else tuple((float(f), float(z)) for f, z in modes)
    return Bench(loop, distance, tolerance, speed, push, found, 6.0 * fastest + slowest)


def _loop_of(plant: Any) -> ServoLoop:
    """Return an axis in the loop that this file's docstring gives it."""
    axis = as_axis(plant)
    held = _held(axis)
    if not held:
        raise ValueError(
            "an axis without a mode has none to wait for: give a ServoLoop, whose PID settles"
        )
    pid = design_pid(
        axis, crossover_hz=held[0][0] / 6.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0
    )
    return ServoLoop(axis, pid, low_frequency_feedforward(axis))


def _acceleration(axis: Axis, given: float | None) -> float:
    if given is not None:
        return positive("acceleration", given)
    if axis.torque_limit == inf:
        raise ValueError(
            "acceleration is missing, and the axis has no torque_limit to take it from: give "
            "acceleration=…"
        )
    return 0.8 * (axis.torque_limit - abs(axis.constant_load)) / axis.J


def _held(axis: Axis) -> list[tuple[float, float]]:
    """Return frequencies and damping of the modes with the motor held, lowest first."""
    from dataclasses import replace

    numerator = replace(axis, sensor="motor").transfer().num_array[0, 0]
    return _modes(np.roots(numerator))


def _ringing(loop: ServoLoop) -> tuple[tuple[float, float], ...]:
    """Return the mode that rings longest in the loop, if any does."""
    found = _held(loop.axis)
    if not loop.is_digital:
        closed = _modes(np.linalg.eigvals(loop.system().A))
        found = sorted(closed, key=lambda mode: mode[0] * mode[1])
    return tuple(found[:1])


def _modes(poles: Any) -> list[tuple[float, float]]:
    pairs = [(abs(p), max(-p.real / abs(p), 0.0)) for p in poles if p.imag > 0.0]
    return sorted((w / (2.0 * pi), float(z)) for w, z in pairs if z < _LIGHT)


def _families(orders: Sequence[int], shapers: Sequence[str], bench: Bench) -> list[Family]:
    for order in orders:
        if order not in (3, 4):
            raise ValueError(
                f"orders = {shown(tuple(orders))}: expected 3 (jerk), 4 (snap) or both"
            )
    for kind in shapers:
        one_of("shapers", kind, ("ZV", "ZVD", "ZVDD", "EI"))
    if not orders:
        raise ValueError("orders is empty: expected 3 (jerk), 4 (snap) or both")
    shaped = shapers if bench.modes else ()
    return [Family(n) for n in orders] + [Family(min(orders), kind) for kind in shaped]


def _searched(bench: Bench, family: Family) -> list[LimitTrial]:
    """Return the trials of a family: a grid, then finer ones about its best."""
    fastest = _rest_time(bench)
    period = min((1.0 / f for f, _ in bench.modes), default=fastest)
    low = min(0.02 * fastest, 0.25 * period)
    ramps = np.geomspace(low, fastest, _RAMPS)
    shares = np.array(_SHARES if family.order == 4 else (1.0,))
    known: dict[tuple[float, float], LimitTrial] = {}

    def best() -> tuple[float, float]:
        return min(known, key=lambda place: (known[place].saturates, *_rank(known[place])))

    def look(places: Any) -> None:
        for ramp, share in places:
            if (ramp, share) not in known:
                known[ramp, share] = bench.trial(family, bench.limits(family, ramp, share))

    look((float(r), float(s)) for r in ramps for s in shares)
    step = ramps[1] / ramps[0]
    for _ in range(_ROUNDS):
        step = step ** (1.0 / 3.0)
        ramp, share = best()
        beside = [1.0] if family.order == 3 else [share / step, share, min(share * step, 1.0)]
        look((ramp * step**k, s) for k in (-2, -1, 0, 1, 2) for s in beside)
    return list(known.values())


def _rest_time(bench: Bench) -> float:
    """Return the time of the move without a bound on jerk."""
    push, way = bench.acceleration, abs(bench.distance)
    if bench.velocity**2 >= way * push:
        return 2.0 * sqrt(way / push)
    return way / bench.velocity + bench.velocity / push


def _best(bench: Bench, trials: Sequence[LimitTrial]) -> LimitTrial | None:
    """Return the best as it is exactly, which on a grid it may have only seemed."""
    best: LimitTrial | None = None
    for trial in sorted(_allowed(trials), key=_rank)[:_FINALISTS]:
        if best is not None and best.settling_time <= trial.settling_time:
            break
        again = bench.exact(trial)
        best = again if best is None else min(best, again, key=_rank)
    return best


def _rank(trial: LimitTrial) -> tuple[float, float]:
    return trial.settling_time, trial.peak_torque


def _allowed(trials: Sequence[LimitTrial]) -> list[LimitTrial]:
    return [trial for trial in trials if not trial.saturates]


def _share(bench: Bench, trial: LimitTrial) -> float:
    """Return the part of acceleration's ramp in which jerk rises."""
    return 1.0 if trial.order == 3 else trial.jerk**2 / (trial.snap * bench.acceleration)


def _shaper(bench: Bench, kind: str) -> InputShaper | None:
    if not kind:
        return None
    frequencies, dampings = zip(*bench.modes, strict=True)
    return input_shaper(kind, frequencies, dampings)  # type: ignore[arg-type]


def _never(bench: Bench, trials: Sequence[LimitTrial]) -> ValueError:
    if not _allowed(trials):
        return ValueError(
            f"acceleration = {shown(bench.acceleration)}: every move reaches the torque limit, "
            f"{shown(bench.loop.axis.torque_limit)}; lower it, or the loop's gains"
        )
    return ValueError(
        f"settle_to = {shown(bench.tolerance)}: no move settles within "
        f"{bench.horizon:.4g}; allow more, "
        "feed more derivatives forward (low_frequency_feedforward), or raise the crossover"
    )
