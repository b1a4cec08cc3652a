"""The input shapers that a scenario file of format 2 asks for."""

from __future__ import annotations

from difflib import get_close_matches
from math import sqrt
from typing import TYPE_CHECKING

from ..shaping import InputShaper, input_shaper
from .units import show

if TYPE_CHECKING:
    from .scenario_asked import ShaperSection
    from .scenario_formats import FileOf2, ModeOf2
    from .scenario_sections import ModeSection


def shapers_of(shaper: ShaperSection, file: FileOf2) -> tuple[InputShaper, ...]:
    """Return one shaper for each mode that is to be nulled."""
    if shaper.frequency is not None:
        modes = [(shaper.frequency, shaper.damping)]
    else:
        modes = [_mode(name, file) for name in shaper.modes or ()]
    return tuple(
        input_shaper(shaper.kind, frequency, damping, vibration=shaper.vibration)
        for frequency, damping in modes
    )


def _mode(name: str, file: FileOf2) -> tuple[float, float]:
    """Return frequency and damping of a mode of the file, as the drive believes them to be."""
    known = {mode.name: _believed(mode) for mode in file.modes}
    known |= {mode.name: held_mode(mode) for mode in file.plant.modes if mode.name is not None}
    if name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        there = ", ".join(map(show, known)) or "none with a name"
        raise ValueError(f"{show(name)} is no mode of this file; {hint}write one of: {there}")
    return known[name]


def _believed(mode: ModeOf2) -> tuple[float, float]:
    frequency, damping = mode.believed_frequency, mode.believed_damping
    return frequency or mode.frequency, (mode.damping if damping is None else damping) / 100.0


def held_mode(mode: ModeSection) -> tuple[float, float]:
    """Return a mode of the plant as it is with the motor held, which a stiff loop does."""
    if mode.held or mode.load_fraction is None:
        return mode.frequency, mode.damping
    share = sqrt(1.0 - mode.load_fraction)
    return mode.frequency * share, mode.damping * share
