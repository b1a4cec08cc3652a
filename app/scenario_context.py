"""What the check of one key must know of the rest of a scenario file."""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from decimal import Decimal, DecimalException
from typing import Any

from .counted_units import spelled_out
from .units import (
    Kind,
    Motion,
    UnitError,
    motion_kind,
    parse_any,
    parse_motion,
    parse_quantity,
    parted,
    show,
)


def positive_kind(name: str, example: str, *, below: float = math.inf) -> Kind:
    """Return a kind of positive quantity."""
    unit = example.split(maxsplit=1)[1]
    return Kind(name=name, unit=unit, example=example, above=0.0, below=below)


INERTIA_KINDS: dict[Motion, tuple[Kind, ...]] = {
    "angle": (
        positive_kind("a positive moment of inertia for angular moves", "1 kg m^2"),
        positive_kind("a positive torque per angular acceleration", "1 N m s^2/rad"),
    ),
    "length": (positive_kind("a positive mass for linear moves", "1 kg"),),
}
_STIFFNESS: dict[Motion, str] = {"angle": "N m/rad", "length": "N/m"}
_PER_SECOND = re.compile(r"1?\s*/\s*s")


@dataclass(frozen=True)
class Context:
    """What the file moves, the names in it, and what a count and a sample are."""

    motions: tuple[Motion, ...]
    limit_sets: tuple[str, ...]
    counted: dict[str, str] = field(default_factory=dict)
    moves: set[str] = field(default_factory=set)
    modes: set[str] = field(default_factory=set)
    tracking: set[str] = field(default_factory=set)

    def quantity(self, value: object, kinds: Callable[[Motion], Sequence[Kind]]) -> float:
        """Return a quantity of a kind that fits the file's motions."""
        accepted = list(dict.fromkeys(kind for m in self.motions for kind in kinds(m)))
        if not accepted:
            raise UnitError(
                f"{show(value)} is of a linear axis, and this one turns; write inertia instead, or "
                "moves in units of length"
            )
        text = self.plain(value)
        try:
            return parse_any(text, accepted)[0]
        except UnitError as error:
            raise UnitError(str(error).replace(show(text), show(value), 1)) from None

    def moved(self, value: object, derivative: int, *, positive: bool = False) -> float:
        """Return a position or one of its derivatives."""
        return self.quantity(value, lambda m: [motion_kind(m, derivative, positive=positive)])

    def plain(self, value: object) -> object:
        """Return a text with counts of the encoder, or samples, in the unit of what they count."""
        if not isinstance(value, str):
            return value
        parts = parted(value)
        if parts is None:
            return value
        if _PER_SECOND.fullmatch(parts[1]):
            return f"{parts[0]} s^-1"
        if not ("count" in parts[1] or "sample" in parts[1]):
            return value
        size, unit = self.spelled_out(parts[1], value)
        try:
            return f"{Decimal(parts[0]) * size} {unit}"
        except DecimalException:
            return value

    def spelled_out(self, unit: str, whole: object) -> tuple[Decimal, str]:
        """Return a unit without counts and samples, and by what it is to be multiplied."""
        try:
            return spelled_out(unit, self.counted)
        except UnitError as error:
            raise UnitError(str(error).replace(show(unit), show(whole), 1)) from None


def context_of(content: dict[str, Any]) -> Context:
    """Return the context of a file: what most quantities say they are, so that a slip shows."""
    votes: Counter[Motion] = Counter(_votes(content))
    sets = content.get("limits")
    return Context(
        motions=(votes.most_common(1)[0][0],) if votes else ("angle", "length"),
        limit_sets=tuple(sets) if isinstance(sets, dict) else (),
        counted=_counted(content),
    )


def _votes(content: dict[str, Any]) -> Iterator[Motion]:
    """Yield what each quantity says it is, of those that can be but one of the two."""
    plant, moves = _table(content, "plant"), content.get("moves")
    chain = _table(plant, "chain").get("masses")
    masses = chain[:1] if isinstance(chain, list) else []
    for inertia in (plant.get("inertia"), plant.get("mass"), *masses):
        for motion, kinds in INERTIA_KINDS.items():
            with suppress(UnitError):
                parse_any(inertia, kinds)
                yield motion
    with suppress(UnitError):
        yield parse_motion(plant.get("encoder_step"), 0)[1]
    if "encoder_counts" in plant:
        yield "angle"
    if "frf" in plant:  # which has no unit of its own
        kp = _table(_table(content, "controller"), "gains").get("kp")
        for motion, unit in _STIFFNESS.items():
            with suppress(UnitError):
                parse_quantity(kp, positive_kind("a gain", f"1 {unit}"))
                yield motion
    for move in moves if isinstance(moves, list) else ():
        for key in ("distance", "settle_to") if isinstance(move, dict) else ():
            with suppress(UnitError):
                yield parse_motion(move.get(key), 0)[1]


def _counted(content: dict[str, Any]) -> dict[str, str]:
    """Return the encoder's step and the sample time, where they are right."""
    plant, sample = _table(content, "plant"), _period(content)
    step, counts = plant.get("encoder_step"), plant.get("encoder_counts")
    found = {}
    if isinstance(counts, int) and not isinstance(counts, bool) and counts > 0:
        found["count"] = f"{Decimal(1) / Decimal(counts)} rev"
    with suppress(UnitError):
        parse_motion(step, 0, positive=True)
        found["count"] = str(step)
    with suppress(UnitError):
        parse_quantity(sample, positive_kind("a duration", "1 ms"))
        found["sample"] = str(sample)
    return found


def _period(content: dict[str, Any]) -> object:
    return _table(content, "controller").get("sample_time")


def _table(content: dict[str, Any], key: str) -> dict[str, Any]:
    value = content.get(key)
    return value if isinstance(value, dict) else {}
