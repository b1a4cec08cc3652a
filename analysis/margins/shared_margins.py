"""Margins of many servo loops, each kind found for all of them when one is first asked for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ...plant import ServoLoop
from .bandwidth import bandwidth
from .factored_loop import Complex, FactoredLoop, Real, is_stable
from .factoring import factored_all, tried
from .many_crossings import OnePieces, pieces_of
from .many_crossings import stable as stable_by_count
from .many_gain_and_phase import gain_margins, phase_and_delay
from .many_modulus import QUOTIENT, modulus
from .one_loop import inverse_pieces, loop_margins
from .result import LoopMargins
from .rooted_loops import alike, rooted, without_cancelled


class SharedMargins:
    """The margins of one of many loops, by the names of `LoopMargins`.

    Attributes
    ----------
    stable : bool
    closed_loop_poles : (n,) array of complex
        As `LoopMargins` lists them.
    dt : float or None
    """

    def __init__(self, group: _Group, row: int) -> None:
        self._group, self._row = group, row
        loop = group.loops[row]
        self.stable = bool(group.stable[row])
        self.closed_loop_poles: Complex = loop.closed_loop_poles()
        self.dt = loop.dt

    def __getattr__(self, name: str) -> float:
        if name.startswith("_"):
            raise AttributeError(name)
        return float(self._group.values(name)[self._row])


AnyMargins = SharedMargins | LoopMargins


class SharedLoops:
    """Servo loops whose margins are found together, once one is asked for.

    Parameters
    ----------
    loops : sequence of ServoLoop
        Those that differ in their feedforward alone share their margins.
    """

    def __init__(self, loops: Sequence[ServoLoop]) -> None:
        self._loops = tuple(loops)

    def margins(self, index: int) -> AnyMargins:
        """Return the margins of one of the loops; raises what `loop_margins` raises."""
        found = self._found[index]
        if isinstance(found, Exception):
            raise found
        return found

    @cached_property
    def _found(self) -> list[AnyMargins | Exception]:
        first: list[int] = []
        for loop in self._loops:
            first.append(next((k for k in first if _same(self._loops[k], loop)), len(first)))
        distinct = sorted(set(first))
        factors = _factors([self._loops[k] for k in distinct])
        found: dict[int, Any] = dict(zip(distinct, factors, strict=True))
        kinds: dict[Any, list[int]] = {}
        for k in sorted(found):
            if isinstance(found[k], FactoredLoop):
                kinds.setdefault(alike(found[k]), []).append(k)
        for members in kinds.values():
            found |= _together({k: found[k] for k in members}, self._loops)
        return [found[k] for k in first]


def _same(one: ServoLoop, other: ServoLoop) -> bool:
    return bool(one.controller == other.controller and one.plant == other.plant)


def _factors(loops: Sequence[ServoLoop]) -> list[FactoredLoop | LoopMargins | Exception]:
    """Return the factors of open loops; of those without gain their margins at once."""
    found: list[Any] = [tried(ServoLoop.open_model, loop) for loop in loops]
    known = [k for k, model in enumerate(found) if not isinstance(model, Exception)]
    for k, factors in zip(known, factored_all([found[k] for k in known]), strict=True):
        found[k] = factors
    return [
        each if isinstance(each, Exception) else tried(_reduced, loop, each)
        for loop, each in zip(loops, found, strict=True)
    ]


def _reduced(loop: ServoLoop, factors: FactoredLoop) -> FactoredLoop | LoopMargins:
    found = without_cancelled(factors)
    return found if found.gain else loop_margins(loop)


def _together(
    factors: Mapping[int, FactoredLoop], loops: Sequence[ServoLoop]
) -> dict[int, AnyMargins | Exception]:
    """Return the margins of loops that are alike; of each by itself where one of them fails."""
    try:
        group = _Group(list(factors.values()))
    except (ValueError, ArithmeticError):
        return {k: tried(loop_margins, loops[k]) for k in factors}
    return {k: SharedMargins(group, row) for row, k in enumerate(factors)}


class _Group:
    """Loops that are alike, and what is known of them; only stable ones have margins."""

    def __init__(self, loops: Sequence[FactoredLoop]) -> None:
        self.loops = loops
        with np.errstate(all="ignore"):
            whole = pieces_of(rooted(*loops))
            counted = stable_by_count(whole) if loops[0].samples else np.ones(len(loops), bool)
        listed = [is_stable(np.concatenate([loop.closed, loop.hidden])) for loop in loops]
        self.stable = counted & np.array(listed)
        self._pieces: OnePieces = whole.take(self.stable)

    def values(self, name: str) -> Real:
        """Return a margin of all loops, nan of unstable ones."""
        values = np.full(len(self.loops), np.nan)
        if self.stable.any():
            with np.errstate(all="ignore"):
                found = self._found(name)
            values[self.stable] = self._hertz(found) if name.endswith("_hz") else found
        return values

    def _found(self, name: str) -> Real:
        for known in (self._phase, self._gain[0]):
            if name in known:
                return known[name]
        if name.startswith("bandwidth"):
            return self._bandwidth
        return _OF_DISTANCES[name](self)

    def _hertz(self, omega: Real) -> Real:
        return np.asarray(self._pieces.loops.radians(omega[:, None])[:, 0] / (2.0 * np.pi))

    @cached_property
    def _phase(self) -> Mapping[str, Real]:
        return phase_and_delay(self._pieces)

    @cached_property
    def _gain(self) -> tuple[Mapping[str, Real], tuple[Real, Real]]:
        return gain_margins(self._pieces)

    @cached_property
    def _inverse(self) -> OnePieces:
        return inverse_pieces(self._pieces)

    @cached_property
    def _of_s(self) -> tuple[Real, Real]:
        return modulus(self._pieces, self._gain[1])

    @cached_property
    def _of_t(self) -> tuple[Real, Real]:
        gain, omega = self._gain[1]
        return modulus(self._inverse, (-gain, omega))

    @cached_property
    def _of_disks(self) -> tuple[Real, Real]:
        return modulus(self._pieces, self._gain[1], QUOTIENT)

    @cached_property
    def _bandwidth(self) -> Real:
        count = np.arange(len(self._inverse.omega))
        return np.array([bandwidth(self._inverse.take(count[k : k + 1])) for k in count])


_OF_DISTANCES: Mapping[str, Callable[[Any], Real]] = {
    "modulus_margin": lambda group: group._of_s[0],
    "modulus_margin_hz": lambda group: group._of_s[1],
    "sensitivity_peak": lambda group: 1.0 / group._of_s[0],
    "sensitivity_peak_hz": lambda group: group._of_s[1],
    "complementary_peak": lambda group: 1.0 / group._of_t[0],
    "complementary_peak_hz": lambda group: group._of_t[1],
    "disk_margin": lambda group: 2.0 * group._of_disks[0],
    "disk_margin_hz": lambda group: group._of_disks[1],
}
