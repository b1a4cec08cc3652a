"""Figures 1 to 6 of Thompson's "Snap, Crackle, and Pop": moves, and following a command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from jounce.plots.motions import plot_following, plot_phase_plane
from jounce.plots.style import (
    BLUE,
    CURVE_POINTS,
    GREY,
    ORDER_COLORS,
    unit_label,
    with_rest,
)
from jounce.shaping import (
    CommandFollower,
    FollowerResponse,
    Limits,
    Trajectory,
    bound_for_rise_time,
    min_time_move,
    perfect_spline,
)
from jounce.shaping.derivatives import derivative_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SYMBOLS = {1: "V", 2: "A", 3: "W"}  # Thompson's names of the limits


@dataclass(frozen=True)
class _Column:
    """A column of panels: what moves, within which limits, and names of its switch times."""

    title: str
    moves: tuple[Trajectory, ...]
    limits: Limits
    switches: tuple[str, ...] = ()


def figure_1() -> Figure:
    """Draw minimum-time moves with velocity and acceleration limited.

    A short move turns from full acceleration to full deceleration half-way and takes
    T = 2√(R/A). One longer than V²/A reaches the velocity limit after t_v = V/A and takes
    T = t_v + R/V. Here V = 1 deg/s and A = 1 deg/s².

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section II.
    """
    limits = Limits(velocity=1.0, acceleration=1.0)
    cases = (
        ("R < V²/A: V is not reached", 0.5, "0 T/2 T"),
        ("R ≥ V²/A: V is reached", 2.0, "0 t_v T-t_v T"),
    )
    columns = [_case(title, distance, limits, names) for title, distance, names in cases]
    return _draw(columns, derivatives=(0, 1, 2), size=(8.5, 6.0))


def figure_2() -> Figure:
    """Draw how a command is followed with velocity and acceleration limited.

    The command steps while the axis moves. Every sample of the response is the first one of a
    minimum-time move to the present command, so that velocity and acceleration keep their
    limits V = 2 deg/s and A = 1 deg/s² throughout. In the phase plane the axis comes to rest
    along the braking parabola of its command, v² = 2A·|command − position|.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section II.
    """
    limits = Limits(velocity=2.0, acceleration=1.0)
    dt = 0.01
    time = dt * np.arange(1600)
    commands = np.select([time < 5.0, time < 7.5], [4.0, 10.0], default=2.0)
    response = CommandFollower(limits, dt=dt).run(commands)
    figure = Figure(figsize=(10.5, 6.0), layout="constrained")
    grid = figure.add_gridspec(3, 2)
    axes = [figure.add_subplot(grid[row, 0]) for row in range(3)]
    plot_following(response, ax=axes[0], unit="deg").legend(loc="upper left")
    for k in (1, 2):
        axes[k].plot(response.time, response.states[k], color=BLUE)
        axes[k].set_ylabel(derivative_name(k) + unit_label("deg", "s", k))
        axes[k].grid(alpha=0.3)
        for bound in limits.bounds(k):
            _mark_bound(axes[k], bound, k)
    axes[0].set_title("Command and response", fontsize=11)
    for ax in axes[:2]:
        ax.sharex(axes[2])
        ax.tick_params(labelbottom=False)
        ax.set_xlabel("")
    axes[2].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    _phase_plane(response, limits, ax=figure.add_subplot(grid[:, 1]))
    return figure


def figure_3() -> Figure:
    """Draw the four cases of a minimum-time move with velocity, acceleration and jerk limited.

    Which of the limits V and A are reached decides on the duration: with t_w = A/W it is
    (32R/W)^(1/3) for neither, t_w + √(t_w² + 4R/A) for A alone, R/V + 2√(V/W) for V alone, and
    R/V + t_w + V/A for both. V = 1 deg/s and W = 2 deg/s³ in all of them, A = 1 deg/s² but in
    the third, where it is 2 deg/s².

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section III.
    """
    tight, loose = Limits(1.0, 1.0, 2.0), Limits(1.0, 2.0, 2.0)
    cases = (
        ("1: neither V nor A reached", 0.4, tight, "0 T/4 3T/4 T"),
        ("2: A reached, V not", 1.0, tight, "0 t_w T/2-t_w T/2+t_w T-t_w T"),
        ("3: V reached, A not", 2.0, loose, "0 t_v/2 t_v T-t_v T-t_v/2 T"),
        ("4: both reached", 2.0, tight, "0 t_w t_v-t_w t_v T-t_v T-t_v+t_w T-t_w T"),
    )
    return _draw([_case(*case) for case in cases], derivatives=(0, 1, 2, 3), size=(13.0, 7.6))


def figure_4() -> Figure:
    """Draw moves with nothing but snap, crackle or pop limited: perfect splines.

    All three cover the distance R in the time T. Derivative n jumps between ± its bound
    D = R·(n−1)!·4^(n−1)/Tⁿ at the times T·sin²(kπ/2n). With each derivative more that is
    continuous, a move of the same duration is gentler at its ends and faster in the middle.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV.
    """
    splines = [perfect_spline(1.0, n, 1.0) for n in (4, 5, 6)]
    splines = [spline.stretch(1.0 / spline.duration) for spline in splines]
    figure = Figure(figsize=(11.0, 7.2), layout="constrained")
    (position, *left), (key, *right) = figure.subplots(4, 2, sharex=True).T
    for k, ax in enumerate([position, *left, *right]):
        for spline in splines:
            if k <= spline.order:
                time = with_rest(spline)
                ax.plot(time, spline(time, k), color=ORDER_COLORS[spline.order])
        ax.set_ylabel(derivative_name(k) + unit_label("R", "T", k))
        ax.grid(alpha=0.3)
    for column in (left, right):
        column[-1].set_xlabel("time [T]")
    entries = [f"{_limited(spline, 'R', 'T')}" for spline in splines]
    key.legend(position.lines, entries, loc="center", fontsize=11)
    key.axis("off")
    figure.align_ylabels([position, *left])
    figure.align_ylabels(right)
    return figure


def figure_6() -> Figure:
    """Draw longer moves, with acceleration limited as well, and with velocity.

    The bound on snap, crackle or pop follows from a rise time. Each ramp of the acceleration
    to A = 0.2 deg/s² is a perfect spline of its own and takes t_r = 1 s whatever the order: for
    pop, D = 76.8 deg/s⁶.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV.
    """
    acceleration, rise_time = 0.2, 1.0
    columns = []
    for title, velocity in (("2 deg, A limited", None), ("2 deg, A and V limited", 0.4)):
        bounds = {n: bound_for_rise_time(acceleration, rise_time, n) for n in (4, 5, 6)}
        limits = [
            Limits.from_bounds([velocity, acceleration, *[None] * (n - 3), bound])
            for n, bound in bounds.items()
        ]
        moves = tuple(min_time_move(2.0, each, method="closed-form") for each in limits)
        columns.append(_Column(title, moves, limits[-1]))
    figure = _draw(columns, derivatives=(0, 1, 2, 3, 6), size=(11.0, 9.0))
    for ax in figure.axes[:2]:
        ax.legend(loc="lower right", fontsize=8.5)
    return figure


def _case(title: str, distance: float, limits: Limits, switches: str) -> _Column:
    move = min_time_move(distance, limits, method="closed-form")  # as in the paper
    title = f"{title}\nR = {distance:g} deg, T = {move.duration:.4f} s"
    return _Column(title, (move,), limits, tuple(switches.split()))


def _draw(
    columns: Sequence[_Column], *, derivatives: Sequence[int], size: tuple[float, float]
) -> Figure:
    """Return a picture with a row of panels for each derivative."""
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(derivatives), len(columns), sharex="col", sharey="row")
    slanted = any(len(column.switches) > 4 for column in columns)
    pad = 48.0 if slanted else 18.0 if columns[0].switches else 6.0
    for panels, column in zip(axes.T, columns, strict=True):
        for ax, k in zip(panels, derivatives, strict=True):
            _draw_derivative(column, k, ax=ax)
        _name_switches(column, panels)
        panels[0].set_title(column.title, fontsize=11, y=1.0, pad=pad)
        panels[-1].set_xlabel("time [s]")
    for ax, k in zip(axes[:, 0], derivatives, strict=True):
        ax.set_ylabel(derivative_name(k) + unit_label("deg", "s", k))
    figure.align_ylabels(axes[:, 0])
    return figure


def _draw_derivative(column: _Column, k: int, *, ax: Axes) -> None:
    """Draw derivative k of the moves that have one, and the limits on the sides in question."""
    moves = [move for move in column.moves if k <= move.order]
    for move in moves:
        time = with_rest(move)
        color = ORDER_COLORS[move.order] if len(column.moves) > 1 else BLUE
        label = f"{_limited(move, 'deg', 's')}: T = {move.duration:.3f} s"
        ax.plot(time, move(time, k), color=color, label=label)
    backwards = moves[-1].extremes(k)[0] < 0.0
    for bound in column.limits.bounds(k) if k else ():
        if np.isfinite(bound) and (backwards or bound > 0.0):
            _mark_bound(ax, bound, k)
    ax.grid(alpha=0.3)


def _limited(move: Trajectory, unit: str, time_unit: str) -> str:
    """Return the limit on the highest derivative of a move in words."""
    n = move.order
    power = unit_label(unit, time_unit, n).strip("\n[]")
    return f"{derivative_name(n)} ±{move.peak(n):,.6g} {power}"


def _mark_bound(ax: Axes, bound: float, k: int) -> None:
    """Draw a limit as a dashed line, its symbol at the right end."""
    ax.axhline(bound, color=GREY, linewidth=0.8, linestyle="--")
    text = ("" if bound > 0.0 else "−") + _SYMBOLS.get(k, "D")
    where = ax.get_yaxis_transform()
    ax.text(1.01, bound, text, transform=where, va="center", color=GREY, fontsize=9)


def _name_switches(column: _Column, panels: Sequence[Axes]) -> None:
    """Draw the switch times through a column, their names on top."""
    if not column.switches:
        return
    times = column.moves[0].switch_times
    for ax in panels:
        for time in times:
            ax.axvline(time, color=GREY, linewidth=0.6, linestyle=":")
    top = panels[0].secondary_xaxis("top")
    names = [f"${name}$" for name in column.switches]
    top.set_xticks(times, names, fontsize=8)
    if len(names) > 4:
        for tick in top.get_xticklabels():
            tick.set(rotation=60, ha="left", rotation_mode="anchor")
    top.tick_params(length=2)


def _phase_plane(response: FollowerResponse, limits: Limits, *, ax: Axes) -> None:
    """Draw the phase plane with the limits and the braking parabola of every command."""
    fastest, braking = limits.bounds(1)[1], limits.bounds(2)[1]
    velocity = np.linspace(-fastest, fastest, CURVE_POINTS)
    for i, command in enumerate(np.unique(response.commands)):
        position = command - velocity * np.abs(velocity) / (2.0 * braking)
        label = "" if i else "braking parabolas"
        ax.plot(position, velocity, ":", color=GREY, linewidth=1.0, label=label)
    plot_phase_plane(response, ax=ax, unit="deg")
    for bound in limits.bounds(1):
        _mark_bound(ax, bound, 1)
    ax.set_ylim(-1.35 * fastest, 1.15 * fastest)
    ax.legend(loc="lower center", ncols=2)
    ax.set_title("Phase plane", fontsize=11)
