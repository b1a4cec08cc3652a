"""A proof that durations are impossible, as data: what a certificate saves, loads and checks."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import inf, isfinite, isinf
from pathlib import Path
from typing import Any

Numbers = tuple[float, ...]
Slopes = tuple[tuple[float, float], ...]
"""dT/d(lower bound), dT/d(upper bound) of position and derivatives 1 … n."""

_FORMAT = "jounce minimum-time proof, 1"
_OF_TAYLOR = ("derivative", "remainder", "sign")


@dataclass(frozen=True)
class TaylorLink:
    """Durations from low to high are impossible by Taylor's formula about the start.

    sign·(b_k − Σ_{k≤q<m} a_q·T^(q−k)/(q−k)!) > (bound of sign·x^(m))·T^(m−k)/(m−k)!
    """

    low: float
    high: float
    derivative: int
    remainder: int
    sign: int


@dataclass(frozen=True)
class CostateLink:
    """Durations from low to high are impossible by multipliers, those of `costate`.

    Attributes
    ----------
    low, high : float
    cells : tuple of N floats
        Lengths of the grid's cells; their sum stands for the duration.
    ends : tuple of n floats
        λ_k; of fewer where the bounds on derivatives up to their number alone exclude.
    atoms : tuple of (k, N floats)
        Of μ_k at the cells' right ends.
    densities : tuple of (k, rows)
        Bernstein coefficients of the density of μ_k, row j that of degree j on every cell.
    free : "", "start" or "end"
        With λ = 0, of a motion that only has to leave the start in the bounds, or to come to the
        end (then seen backwards in time): all durations from `low` on are impossible.
    """

    low: float
    high: float
    cells: Numbers
    ends: Numbers
    atoms: tuple[tuple[int, Numbers], ...]
    densities: tuple[tuple[int, tuple[Numbers, ...]], ...]
    free: str = ""


@dataclass(frozen=True)
class MirroredLink:
    """Durations up to high are impossible by multipliers of the first half, from rest to rest.

    In the second half p_k(1 − τ) = (−1)^k·p_k(τ), and so μ_k(1 − τ) = (−1)^(k+1)·μ_k(τ).

    Attributes
    ----------
    low, high : float
    cells, ends, atoms, densities
        As in `CostateLink`, of the first half and in time units of its own; ends are p_k at its
        end, zero for odd k.
    cruise : float
        Time between the halves, in which μ_1 = −p_0 and all other p_k are zero.
    """

    low: float
    high: float
    cells: Numbers
    ends: Numbers
    atoms: tuple[tuple[int, Numbers], ...]
    densities: tuple[tuple[int, tuple[Numbers, ...]], ...]
    cruise: float = 0.0


@dataclass(frozen=True)
class Ramp:
    """Multipliers of a motion up to the velocity of a cruise: λ = (1, 0, …, 0) at its end.

    With them Σ_k of what bounds and start allow, in `time`, is the farthest that it comes.

    Attributes
    ----------
    time : float
    cells, atoms, densities
        As in `CostateLink`.
    """

    time: float
    cells: Numbers
    atoms: tuple[tuple[int, Numbers], ...]
    densities: tuple[tuple[int, tuple[Numbers, ...]], ...]


@dataclass(frozen=True)
class CruisingLink:
    """Durations from low to high are impossible: both ramps and a cruise at v come less far.

    T·hi_1/W is what a cruise of that length adds, W = onto.time + cruise + off.time.

    Attributes
    ----------
    low, high : float
    sign : int
        1 forwards; −1 for the mirror image, x → −x.
    onto, off : Ramp
        From the start on; from the end on, of x(t) → −x(−t).
    cruise : float
    """

    low: float
    high: float
    sign: int
    onto: Ramp
    off: Ramp
    cruise: float


Link = TaylorLink | CostateLink | MirroredLink | CruisingLink


@dataclass(frozen=True)
class Proof:
    """No motion from start to end within the bounds takes less than `lower_bound`.

    Attributes
    ----------
    start, end : tuple of n floats
        Positions count from the start's.
    lower, upper : tuple of n + 1 floats
        Bounds on position and derivatives 1 … n, infinite where there are none.
    links : tuple of Link
        They cover (0, lower_bound). Between states of rest one is enough: who can do it faster
        can wait.
    lower_bound : float
        Infinite where there is no motion at all.
    """

    start: Numbers
    end: Numbers
    lower: Numbers
    upper: Numbers
    links: tuple[Link, ...]
    lower_bound: float

    def text(self) -> str:
        """Return it as JSON: numbers to the last bit, null for no bound."""
        links = [{"kind": type(link).__name__, **vars(link)} for link in self.links]
        data = {"format": _FORMAT, **vars(self), "links": links}
        return json.dumps(_without_infinities(data), indent=None)

    @classmethod
    def from_text(cls, text: str) -> Proof:
        """Return what `text` gave.

        Raises
        ------
        ValueError
            For a text that is none.
        """
        try:
            data = json.loads(text)
            if data.pop("format") != _FORMAT:
                raise ValueError
            links = tuple(map(_link, data.pop("links")))
            lower = tuple(number(x, -inf) for x in data.pop("lower"))
            upper = tuple(number(x, inf) for x in data.pop("upper"))
            bound = number(data.pop("lower_bound"), inf)
            start, end = (_numbers(data.pop(name)) for name in ("start", "end"))
            if not len(lower) == len(upper) == len(start) + 1 == len(end) + 1:
                raise ValueError
        except (KeyError, TypeError, AttributeError, ValueError):
            raise ValueError(
                f"a text that begins with {text[:40]!r} is no proof: expected what "
                "certificate.save wrote"
            ) from None
        return cls(start, end, lower, upper, links, bound)

    def save(self, path: str | Path) -> None:
        """Write it to a file."""
        Path(path).write_text(self.text(), encoding="utf-8")


@dataclass(frozen=True)
class Proven:
    """A lower bound on a duration, what it hangs on (see `Certificate`), and its proof."""

    lower_bound: float
    sensitivities: Numbers
    slopes: Slopes
    proof: Proof


def number(value: object, missing: float | None = None) -> float:
    """Return a finite number out of JSON, `missing` for null; ValueError for anything else."""
    if value is None and missing is not None:
        return missing
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError
    return float(value)


def _link(data: dict[str, Any]) -> Link:
    kind, low, high = data["kind"], number(data["low"]), number(data["high"], inf)
    if kind == "TaylorLink":
        return TaylorLink(low, high, *(_whole(data[name]) for name in _OF_TAYLOR))
    if kind == "CruisingLink":
        onto, off = (
            Ramp(number(data[name]["time"]), *_measures(data[name])) for name in ("onto", "off")
        )
        return CruisingLink(low, high, _whole(data["sign"]), onto, off, number(data["cruise"]))
    cells, atoms, densities = _measures(data)
    multipliers = (cells, _numbers(data["ends"]), atoms, densities)
    if kind == "MirroredLink":
        return MirroredLink(low, high, *multipliers, number(data["cruise"]))
    if kind == "CostateLink":
        return CostateLink(low, high, *multipliers, data["free"])
    raise ValueError


def _measures(data: dict[str, Any]) -> tuple[Any, Any, Any]:
    """Return cells, atoms and densities."""
    return (
        _numbers(data["cells"]),
        tuple((_whole(k), _numbers(row)) for k, row in data["atoms"]),
        tuple((_whole(k), tuple(map(_numbers, rows))) for k, rows in data["densities"]),
    )


def _numbers(values: list[object]) -> Numbers:
    return tuple(map(number, values))


def _whole(value: object) -> int:
    if int(number(value)) != value:
        raise ValueError
    return int(number(value))


def _without_infinities(value: Any) -> Any:
    if isinstance(value, Ramp):
        value = vars(value)
    if isinstance(value, dict):
        return {name: _without_infinities(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_without_infinities(part) for part in value]
    return None if isinstance(value, float) and isinf(value) else value
