"""Whether a loop is stable, counted on what was measured of it; or why that cannot be told.

From the first line f₁ to the last 1 + L turns about 0 by Δ and ends near 1. Its argument begins on
the branch φ₁ that goes with the slope at f₁. With P unstable poles of L and Z of the closed loop

    (P − Z)/2 = Δ + φ₁/360°.

Relative to a controller that the loop ran with, hence stable, no more is needed than that

    (1 + L₁)/(1 + L₀)

does not turn about 0, by a half neither, where both have the same integrators and unstable poles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .controller_values import ControllerValues
from .conversions import Factored
from .loop_grid import LoopGrid, MeasuredLoop
from .rational_fits import Complex, Real

_MOST_STEP = 0.5 * np.pi
_MOST_OFF_REAL = 1.0 / 3.0  # of a half turn, of 1 + L at the first line relative to what ran
_SIGN_DOUBTED = (
    ": inverted sign, or 360° off? check the channels, or declare integrators and unstable_poles"
)
_OFF_SLOPE = 75.0  # degrees that a phase may be off the one of its slope
_OFF_DECLARED, _LEADS = 135.0, 45.0  # a plant lags behind its integrators, hardly ever leads
_FAR_BELOW, _POINTS_BELOW = 1e-4, 200  # of the first line: where a controller is looked at
_LOWEST = 2.0  # what counts as the lowest lines: up to this many times the first
_QUIET = 0.3  # |L| below which what lies between lines hides nothing


class Stability(NamedTuple):
    """The verdict, None where it cannot be told, why, and what was taken for granted."""

    stable: bool | None
    reasons: tuple[str, ...]
    assumed: tuple[str, ...] = ()


def stability(grid: LoopGrid, parts: Factored) -> Stability:
    """Return whether the loop is stable by the count from the first line to the last."""
    doubts = [*_unmeasured(grid), *_hidden(grid)]
    if doubts:
        return Stability(None, tuple(doubts))
    start = _first_turn(grid, parts)
    if isinstance(start, str):
        return Stability(None, (start,))
    declared = parts.fitted.unstable_poles
    unstable = (declared or 0) + parts.controller.unstable_poles
    assumed = (
        ("no unstable pole of the plant is declared: counted with none",)
        if declared is None
        else ()
    )
    turns = _turns(1.0 + grid.value) + start
    closed = round(unstable - 2.0 * turns)
    if closed == 0:
        how = f"with {unstable} unstable poles of L the turns of 1 + L leave the closed loop none"
        return Stability(True, (f"stable: {how}",), assumed)
    if closed < 0:
        return Stability(
            None,
            (
                f"1 + L turns {turns:+.2f} times about 0, more than {unstable} unstable poles of L "
                "allow: declare unstable_poles and integrators",
            ),
            assumed,
        )
    what = f"the closed loop has {closed} unstable poles by the turns of 1 + L"
    return Stability(False, (f"unstable: {what}",), assumed)


def relative_stability(grid: LoopGrid, parts: Factored, ran_with: ControllerValues) -> Stability:
    """Return whether the loop is stable by comparison with the one that ran while measured."""
    own = parts.controller
    for name in ("integrators", "unstable_poles"):
        one, other = getattr(own, name), getattr(ran_with, name)
        if one != other:
            word = name.replace("_", " ")
            return Stability(
                None,
                (
                    f"the controller has {one} {word}, the one that was measured with {other}: "
                    "their loops cannot be compared; declare integrators and unstable_poles and "
                    "leave measured_with out",
                ),
            )
    before = MeasuredLoop(grid.loop.fits, ran_with).at(grid.frequency_hz)
    doubts = [*_hidden(grid), *_hidden_in(1.0 + before.value, before.sigma, grid.frequency_hz)]
    ratio = (1.0 + grid.value) / (1.0 + before.value)
    doubts += _large_steps(ratio, grid)
    if abs(grid.value[-1]) + grid.radius[-1] >= 1.0:
        doubts.append(_last_line(grid))
    far_below = _FAR_BELOW * grid.frequency_hz[:1]
    negative = bool((own.at(far_below) / ran_with.at(far_below)).real[0] < 0.0)
    integrates = bool(own.integrators or parts.fitted.integrators)
    halves = _half_turns(ratio, negative if integrates else None)
    if halves is None:
        doubts.append(_not_real(ratio[0], float(grid.frequency_hz[0])))
    if doubts or halves is None:
        return Stability(None, tuple(doubts))
    if halves == 0:
        how = "1 + L does not turn about 0 relative to the loop that ran"
        return Stability(True, (f"stable: {how}",))
    return Stability(
        False,
        (f"unstable: 1 + L turns {0.5 * halves:+g} times about 0 relative to the loop that ran",),
    )


def _half_turns(ratio: Complex, negative: bool | None) -> int | None:
    """Return the half turns about 0 of a curve from DC, where it is real, to where it is near 1.

    With integrators in L it is that of the controllers at DC, negative or not. Without, the first
    line tells on which side of 0 it began: None where it does not.
    """
    angle = _unwrapped(ratio) / np.pi
    if negative is not None:
        turned = 2 * round(0.5 * float(angle[-1] - angle[0] + negative))
        return turned - negative
    start = round(float(angle[0]))
    if abs(angle[0] - start) > _MOST_OFF_REAL:
        return None
    return 2 * round(0.5 * float(angle[-1])) - start


def _not_real(ratio: complex, hertz: float) -> str:
    return (
        f"1 + L relative to the loop that ran is at {np.degrees(np.angle(ratio)):+.0f}° at the "
        f"first line, {hertz:.4g} Hz, where 0° or 180° tell how it began: measure lower "
        "frequencies, or declare integrators"
    )


def _unmeasured(grid: LoopGrid) -> list[str]:
    """Return what the lines leave out at either end."""
    size, radius = abs(grid.value), grid.radius
    low, high = grid.frequency_hz[[0, -1]]
    if not (size > 1.0).any():
        return [
            f"no line with |L| > 1 from {low:.4g} to {high:.4g} Hz: the crossover was not "
            "measured; measure lower frequencies"
        ]
    if not (size < 1.0).any():
        return [
            f"no line with |L| < 1 from {low:.4g} to {high:.4g} Hz: the crossover was not "
            "measured; measure higher frequencies"
        ]
    if size[-1] + radius[-1] >= 1.0:
        return [_last_line(grid)]
    if size[0] - radius[0] <= 1.0:
        return [
            f"|L| = {size[0]:.3g} at the first line, {low:.4g} Hz: what is below it was not "
            "measured; measure lower frequencies"
        ]
    return []


def _last_line(grid: LoopGrid) -> str:
    return (
        f"|L| = {abs(grid.value[-1]):.3g} ± {grid.radius[-1]:.2g} at the last line, "
        f"{grid.frequency_hz[-1]:.4g} Hz, is not surely below 1: what is above it was not "
        "measured; measure higher frequencies"
    )


def _hidden(grid: LoopGrid) -> list[str]:
    """Return what noise and steps between lines hide."""
    return [
        *_hidden_in(1.0 + grid.value, grid.sigma, grid.frequency_hz),
        *_large_steps(1.0 + grid.value, grid),
    ]


def _hidden_in(around: Complex, sigma: Real, frequency: Real) -> list[str]:
    ratio = abs(around) / np.maximum(sigma, 1e-300)
    at = int(np.argmin(ratio))
    if ratio[at] > np.sqrt(-np.log(0.05)):
        return []
    return [
        f"cannot exclude −1: circle at {frequency[at]:.4g} Hz, |1 + L| = {abs(around[at]):.3g} "
        f"with a radius of {sigma[at] * np.sqrt(-np.log(0.05)):.2g} (95 %); average longer"
    ]


def _large_steps(around: Complex, grid: LoopGrid) -> list[str]:
    steps = abs(np.diff(_unwrapped(around)))
    loud = np.maximum(abs(grid.value[:-1]), abs(grid.value[1:])) > _QUIET
    large = np.flatnonzero((steps > np.where(grid.joined, _MOST_STEP, 0.2)) & loud)
    if not large.size:
        return []
    low, high = grid.frequency_hz[large[0]], grid.frequency_hz[large[0] + 1]
    return [
        f"1 + L turns by {np.degrees(steps[large[0]]):.0f}° from {low:.5g} to {high:.5g} Hz, where "
        "no line is: measure lines between"
    ]


def _unwrapped(around: Complex) -> Real:
    return np.asarray(np.unwrap(np.angle(around)))


def _turns(around: Complex) -> float:
    """Return how often a curve that ends on the right of 0 turns about it, its end taken for 1."""
    angle = _unwrapped(around)
    return float(angle[-1] - angle[0] - np.angle(around[-1])) / (2.0 * np.pi)


def _first_turn(grid: LoopGrid, parts: Factored) -> float | str:
    """Return arg(1 + L) at the first line on its branch, in turns, or why that is not known."""
    around = float(np.degrees(np.angle(1.0 + grid.value[0])))
    found = _phase_of_plant(grid, parts) if parts.controller.system else _phase_of_loop(grid, parts)
    if isinstance(found, str):
        return found
    expected, negative = found
    return (expected - 180.0 * negative + _off(around - expected)) / 360.0


def _phase_of_plant(grid: LoopGrid, parts: Factored) -> tuple[float, bool] | str:
    """Return arg L at the first line and whether L is negative at DC, by the exact controller.

    Below the first line the plant is one of its integrators, as declared or as by its slope.
    """
    first = grid.frequency_hz[:1]
    below = np.unique(
        np.append(np.geomspace(_FAR_BELOW * first[0], first[0], _POINTS_BELOW), first)
    )
    below = np.union1d(below, parts.controller.places(below[0], below[-1]))
    c = parts.controller.at(below)
    declared, fits = parts.fitted.integrators, parts.fitted.fits
    count = fits.power if declared is None else declared
    size = abs(grid.value[0] / c[-1]) * (first[0] / below) ** count * abs(c)
    if (size <= 1.0).any():
        at = below[int(np.argmin(size))]
        return (
            f"|L| falls to {size.min():.3g} at {at:.4g} Hz, below the first line, if the plant is "
            f"one of {count} integrators there: measure lower frequencies"
        )
    phase = float(np.degrees(np.angle(grid.value[0] / c[-1])))
    negative = bool(parts.fitted.unstable_poles) and abs(_off(phase + 90.0 * count)) > 90.0
    expected = 180.0 * negative - 90.0 * count
    off = _off(phase - expected)
    if not -(_OFF_SLOPE if declared is None else _OFF_DECLARED) < off < _LEADS:
        how = "its slope gives" if declared is None else "those declared give"
        return (
            f"the phase of the plant starts at {phase:+.0f}° where {count} integrators, which "
            f"{how}, go with {expected:+.0f}°{_SIGN_DOUBTED}"
        )
    turn = np.degrees(np.unwrap(np.angle(c)))
    start = _off(turn[0] + 90.0 * parts.controller.integrators)
    of_controller = turn[-1] - turn[0] + start - 90.0 * parts.controller.integrators
    return expected + off + float(of_controller), negative


def _phase_of_loop(grid: LoopGrid, parts: Factored) -> tuple[float, bool] | str:
    """Return arg L at the first line, about, and whether L is negative at DC."""
    declared = parts.fitted.integrators
    slope, phase = lowest_slope_and_phase(grid)
    if declared is None:
        expected = 90.0 * slope
        if abs(_off(phase - expected)) > _OFF_SLOPE:
            return (
                f"the phase of L starts at {phase:+.0f}° where its slope of {20.0 * slope:+.0f} dB "
                f"a decade goes with {expected:+.0f}°{_SIGN_DOUBTED}"
            )
        return expected, False
    expected = -90.0 * declared
    negative = bool(parts.fitted.unstable_poles) and abs(_off(phase - expected)) > 90.0
    expected += 180.0 * negative
    if abs(_off(phase - expected)) > _OFF_DECLARED:
        return (
            f"the phase of L starts at {phase:+.0f}° where its integrators give "
            f"{expected:+.0f}°: inverted sign, or 360° off? check the channels, or the integrators "
            "that are declared; measured as a plant, with its controller given, it needs no more"
        )
    return expected, negative


def lowest_slope_and_phase(grid: LoopGrid) -> tuple[float, float]:
    """Return the slope d ln|L|/d ln f and the phase in degrees of the lowest lines."""
    low = grid.frequency_hz <= grid.loop.fits.lines[2:3].max(initial=_LOWEST * grid.frequency_hz[0])
    x = np.log(grid.frequency_hz[low])
    weight = abs(grid.value[low]) / np.maximum(grid.sigma[low], 1e-9 * abs(grid.value[low]))
    slope = float(np.polyfit(x, np.log(abs(grid.value[low])), 1, w=weight)[0])
    phases = np.unwrap(np.angle(grid.value[low]))
    mean = float(np.degrees(np.average(phases, weights=weight**2)))
    return slope, _off(mean)


def _off(degrees: float) -> float:
    """Return an angle between −180 and 180 degrees."""
    return float((degrees + 180.0) % 360.0 - 180.0)
