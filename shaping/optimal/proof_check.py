"""The checker of proofs: rational numbers only, no solver, nothing of the planner.

For multipliers λ_k and μ_k on [0, 1] every motion of duration T has, with z_k = x^(k)·T^k,

    Σ_k λ_k·z_k(1) + Σ_k ∫ z_k dμ_k = Σ_k p_k(0)·z_k(0) + ∫ p_{n−1}·z_n dτ,
    p_k' = −p_{k−1} − μ_k,  p_k(1) = λ_k,  p_{−1} = 0   (integration by parts),

so that none within the bounds takes a T at which c(T) > 0,

    c(T) = Σ_k T^k·[λ_k b_k + lo_k·|μ_k⁺| − hi_k·|μ_k⁻| − p_k(0)·a_k] − T^n·[hi_n ∫p⁺ − lo_n ∫p⁻].

On a grid of length W instead of 1 it is T/W that is raised to powers. For λ = (1, 0, …, 0), the
start being 0, the same says how far x comes at most: ramps and cruise have to come to the end.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise, zip_longest
from math import comb, factorial, inf, lcm

from .proof import CostateLink, CruisingLink, Link, MirroredLink, Proof, Ramp, TaylorLink

Row = list[Fraction]

_HALVINGS = 26  # of a cell on which p changes its sign
_DEPTH = 80  # halvings of an interval of durations
_UNDECIDED = 10**13  # ∫|p| over this is what may be left uncertain about the sign of p


def holds(proof: Proof) -> bool:
    """Tell whether the links exclude every duration below the bound."""
    reached = Fraction(0)
    can_wait = not any((*proof.start[1:], *proof.end[1:])) and all(
        lower <= 0.0 <= upper for lower, upper in zip(proof.lower[1:], proof.upper[1:], strict=True)
    )
    for link in proof.links:
        if not (can_wait or Fraction(link.low) <= reached) or not _excludes(proof, link):
            return False
        if link.high == inf:
            return True
        reached = max(reached, Fraction(link.high))
    return proof.lower_bound < inf and reached >= Fraction(proof.lower_bound)


def polynomial_of(proof: Proof, link: Link) -> Row:
    """Return the coefficients of c(T); none where the link uses a bound that is not there."""
    if isinstance(link, TaylorLink):
        return _taylor(proof, link)
    if isinstance(link, MirroredLink):
        return _mirrored_polynomial(proof, link)
    if isinstance(link, CruisingLink):
        return _cruising_polynomial(proof if link.sign > 0 else _opposite(proof), link)
    return _costate_polynomial(_reversed(proof) if link.free == "end" else proof, link)


def _excludes(proof: Proof, link: Link) -> bool:
    """Tell whether no motion takes a time between the link's."""
    polynomial = polynomial_of(proof, link)
    if isinstance(link, TaylorLink):
        while polynomial and link.low == 0.0 and polynomial[0] == 0:
            polynomial = polynomial[1:]  # T > 0
    elif isinstance(link, CostateLink) and link.free:
        if any(link.ends) or link.free not in ("start", "end") or link.high != inf:
            return False
        return sum(c * Fraction(link.low) ** k for k, c in enumerate(polynomial)) > 0
    if link.high < inf:
        return _positive(polynomial, Fraction(link.low), Fraction(link.high))
    while polynomial and polynomial[-1] == 0:
        polynomial.pop()
    if not polynomial or polynomial[-1] <= 0:
        return False
    if link.low == 0.0:
        return all(c >= 0 for c in polynomial)
    return _positive(polynomial[::-1], Fraction(0), 1 / Fraction(link.low))


def _taylor(proof: Proof, link: TaylorLink) -> Row:
    k, m, sign = link.derivative, link.remainder, link.sign
    if not (0 <= k < m < len(proof.upper) and sign in (1, -1)):
        return []
    bound = proof.upper[m] if sign > 0 else -proof.lower[m]
    if bound == inf:
        return []
    row = [Fraction(0)] * (m - k + 1)
    row[0] += sign * Fraction(proof.end[k])
    for q in range(k, m):
        row[q - k] -= sign * Fraction(proof.start[q]) / factorial(q - k)
    row[m - k] -= Fraction(bound) / factorial(m - k)
    return row


def _reversed(proof: Proof) -> Proof:
    """Return the problem seen backwards in time."""
    n = len(proof.start)
    start, end = (tuple((-1) ** k * x for k, x in enumerate(s)) for s in (proof.end, proof.start))
    lower = tuple(-proof.upper[k] if k % 2 else proof.lower[k] for k in range(n + 1))
    upper = tuple(-proof.lower[k] if k % 2 else proof.upper[k] for k in range(n + 1))
    return Proof(start, end, lower, upper, (), 0.0)


def _opposite(proof: Proof) -> Proof:
    """Return the mirror image of the problem."""
    start, end = (tuple(-x for x in state) for state in (proof.start, proof.end))
    lower, upper = (tuple(-x for x in sides) for sides in (proof.upper, proof.lower))
    return Proof(start, end, lower, upper, (), 0.0)


def _cruising_polynomial(proof: Proof, link: CruisingLink) -> Row:
    """Return the distance less what both ramps and the cruise add to it at most, in T."""
    ahead = _reach(proof, link.onto), _reach(_opposite(_reversed(proof)), link.off)
    if not all(ahead) or link.cruise < 0.0 or proof.upper[1] == inf:
        return []
    total = [a + b for a, b in zip(*ahead, strict=True)]
    total[0] += Fraction(proof.end[0]) - Fraction(proof.start[0])
    total[1] -= Fraction(proof.upper[1]) * Fraction(link.cruise)
    whole = _total(list(map(Fraction, (link.onto.time, link.cruise, link.off.time))))
    return [value / whole**k for k, value in enumerate(total)]


def _reach(proof: Proof, ramp: Ramp) -> Row:
    """Return minus the farthest way from the start, by powers of T over the ramp's time."""
    ends = (1.0, *[0.0] * (len(proof.start) - 1))
    held = _held(CostateLink(0.0, 0.0, ramp.cells, ends, ramp.atoms, ramp.densities), len(ends))
    if held is None or not ramp.time > 0.0:
        return []
    states = [-p * Fraction(x) for p, x in zip(held.first, proof.start, strict=True)]
    states[0] += Fraction(proof.start[0])
    row = _polynomial(proof, held, states)
    return [value * Fraction(ramp.time) ** k for k, value in enumerate(row)]


def _costate_polynomial(proof: Proof, link: CostateLink) -> Row:
    n = min(len(link.ends), len(proof.start))
    held = _held(link, n)
    if held is None:
        return []
    states = [
        Fraction(final) * Fraction(end) - first * Fraction(start)
        for final, end, first, start in zip(
            link.ends, proof.end[:n], held.first, proof.start[:n], strict=True
        )
    ]
    return _polynomial(proof, held, states)


def _mirrored_polynomial(proof: Proof, link: MirroredLink) -> Row:
    """Return the coefficients of c(T) of both halves and the cruise between them."""
    held, cruise = _held(link, len(proof.start)), Fraction(link.cruise)
    if held is None or held.up[0] or held.down[0] or cruise < 0:
        return []
    meets = any(link.ends[1:] if cruise else link.ends[1::2])
    if meets or any((*proof.start[1:], *proof.end[1:])):
        return []
    both = [
        (up + up, down + down) if k % 2 else (up + down, down + up)
        for k, (up, down) in enumerate(zip(held.up, held.down, strict=True))
    ]
    up, down = map(list, zip(*both, strict=True))
    (up if link.ends[0] < 0.0 else down)[1] += abs(Fraction(link.ends[0])) * cruise
    whole = _Held(up, down, [], 2 * held.length + cruise)
    distance = Fraction(proof.end[0]) - Fraction(proof.start[0])
    return _polynomial(proof, whole, [Fraction(link.ends[0]) * distance])


@dataclass(frozen=True)
class _Held:
    """What multipliers on a grid of some length add up to.

    up, down : |μ_k⁺| and |μ_k⁻|, at index n ∫p⁻ and ∫p⁺: what lo_k and −hi_k are worth.
    first : p_k at the grid's start.
    """

    up: Row
    down: Row
    first: Row
    length: Fraction


@lru_cache(maxsize=4)
def _held(link: CostateLink | MirroredLink, n: int) -> _Held | None:
    """Return the sums, which no bound changes; None where the rows do not fit."""
    count = len(link.cells)
    atoms = {k: list(map(Fraction, row)) for k, row in link.atoms}
    densities = {k: [list(map(Fraction, row)) for row in rows] for k, rows in link.densities}
    sizes = {len(row) for rows in (*densities.values(), list(atoms.values())) for row in rows}
    if sizes - {count} or len(link.ends) != n or not all(h > 0.0 for h in link.cells):
        return None
    cells = list(map(Fraction, link.cells))
    sums: list[tuple[Fraction, Fraction]] = []
    first: Row = []
    below: list[Row] = [[] for _ in cells]
    for k, final in enumerate(link.ends):
        sums.append(_masses(cells, atoms.get(k, []), densities.get(k, [])))
        slopes = [_sum(below[i], [row[i] for row in densities.get(k, [])]) for i in range(count)]
        jumps = atoms.get(k, [Fraction(0)] * count)
        below = _integrated(slopes, cells, jumps, Fraction(final))
        first.append(below[0][0])
    sums.append(_areas(below, cells)[::-1])
    up, down = map(list, zip(*sums, strict=True))
    return _Held(up, down, first, _total(cells))


def _polynomial(proof: Proof, held: _Held, states: Row) -> Row:
    """Return c(T), the grid's length standing for T; none where a bound is not there."""
    total = states + [Fraction(0)] * (len(held.up) - len(states))
    for k, (up, down) in enumerate(zip(held.up, held.down, strict=True)):
        for mass, bound in ((up, proof.lower[k]), (down, -proof.upper[k])):
            if mass and bound == -inf:
                return []
            total[k] += mass * Fraction(bound) if mass else 0
    return [value / held.length**k for k, value in enumerate(total)]


def _masses(cells: Row, atoms: Row, densities: list[Row]) -> tuple[Fraction, Fraction]:
    """Return bounds on the positive and the negative mass of a measure."""
    parts = list(atoms)
    for row in densities:
        parts += [h * value / len(densities) for h, value in zip(cells, row, strict=True)]
    up = sum((part for part in parts if part > 0), Fraction(0))
    return up, up - _total(parts)


def _total(row: Row) -> Fraction:
    return sum(row, Fraction(0))


def _sum(left: Row, right: Row) -> Row:
    """Add two polynomials in Bernstein form."""
    degree = max(len(left), len(right)) - 1
    raised = (_raised(part, degree) if part else [] for part in (left, right))
    return [a + b for a, b in zip_longest(*raised, fillvalue=Fraction(0))]


def _raised(row: Row, degree: int) -> Row:
    """Return a polynomial's Bernstein coefficients of a higher degree."""
    while len(row) <= degree:
        d = len(row)
        inner = [(j * row[j - 1] + (d - j) * row[j]) / d for j in range(1, d)]
        row = [row[0], *inner, row[-1]]
    return row


def _integrated(slopes: list[Row], cells: Row, atoms: Row, final: Fraction) -> list[Row]:
    """Return ∫ slope from each time to the end, plus atoms at right ends of cells, plus `final`."""
    found: list[Row] = []
    after = final
    for slope, h, atom in reversed(list(zip(slopes, cells, atoms, strict=True))):
        row = [after + atom]
        for value in reversed(slope):
            row.append(row[-1] + value * h / len(slope))
        row.reverse()
        found.append(row)
        after = row[0]
    found.reverse()
    degree = max(map(len, found)) - 1
    return [_raised(row, degree) for row in found]


def _areas(rows: list[Row], cells: Row) -> tuple[Fraction, Fraction]:
    """Return upper bounds on ∫p⁺ and ∫p⁻."""
    pieces, unit = _whole(
        [[v * h / len(row) for v in row] for row, h in zip(rows, cells, strict=True)]
    )
    whole = sum(abs(sum(piece)) for piece in pieces)
    enough = Fraction(whole, len(pieces) * _UNDECIDED)
    up = down = Fraction(0)
    pending = [(piece, 0, 0) for piece in pieces]  # times 2^shift
    while pending:
        piece, shift, depth = pending.pop()
        above = sum(value for value in piece if value > 0)
        beneath = above - sum(piece)
        if min(above, beneath) <= enough * (1 << shift) or depth == _HALVINGS:
            scale = unit << shift
            up, down = up + Fraction(above, scale), down + Fraction(beneath, scale)
        else:
            pending += [(half, shift + len(piece), depth + 1) for half in _halves(piece)]
    return up, down


def _whole(rows: list[Row]) -> tuple[list[list[int]], int]:
    """Return rows over one denominator, and that."""
    unit = lcm(*(value.denominator for row in rows for value in row))
    return [[value.numerator * (unit // value.denominator) for value in row] for row in rows], unit


def _halves(row: list[int]) -> tuple[list[int], list[int]]:
    """Return the Bernstein coefficients on both halves of an interval times 2^d (de Casteljau)."""
    left, right = [], []
    while row:
        left.append(row[0] << len(row) - 1)
        right.append(row[-1] << len(row) - 1)
        row = [a + b for a, b in pairwise(row)]
    return left, right[::-1]


def _positive(polynomial: Row, low: Fraction, high: Fraction) -> bool:
    """Tell whether a polynomial is positive on [low, high]."""
    d = len(polynomial) - 1
    if d < 0 or low > high:
        return False
    width = high - low
    taylor = [
        width**i * _total([comb(k, i) * polynomial[k] * low ** (k - i) for k in range(i, d + 1)])
        for i in range(d + 1)
    ]
    first = [
        _total([Fraction(comb(j, i), comb(d, i)) * taylor[i] for i in range(j + 1)])
        for j in range(d + 1)
    ]
    pending = [(row, 0) for row in _whole([first])[0]]
    while pending:
        row, depth = pending.pop()
        if min(row) > 0:
            continue
        if row[0] <= 0 or row[-1] <= 0 or depth == _DEPTH:
            return False
        pending += [(half, depth + 1) for half in _halves(row)]
    return True
