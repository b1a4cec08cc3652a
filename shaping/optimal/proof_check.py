"""The checker of proofs: rational numbers only, no solver, nothing of the planner.

For multipliers λ_k and μ_k on [0, 1] every motion of duration T has, with z_k = x^(k)·T^k,

    Σ_k λ_k·z_k(1) + Σ_k ∫ z_k dμ_k = Σ_k p_k(0)·z_k(0) + ∫ p_{n−1}·z_n dτ,
    p_k' = −p_{k−1} − μ_k,  p_k(1) = λ_k,  p_{−1} = 0   (integration by parts),

so that none within the bounds takes a T at which c(T) > 0,

    c(T) = Σ_k T^k·[λ_k b_k + lo_k·|μ_k⁺| − hi_k·|μ_k⁻| − p_k(0)·a_k] − T^n·[hi_n ∫p⁺ − lo_n ∫p⁻].
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, zip_longest
from math import comb, factorial, inf

from .proof import CostateLink, Proof, TaylorLink

Row = list[Fraction]

_HALVINGS = 26  # of a cell on which p changes its sign
_DEPTH = 80  # halvings of an interval of durations
_UNDECIDED = Fraction(1, 10**13)  # of ∫|p|: what is left uncertain about the sign of p


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


def _excludes(proof: Proof, link: TaylorLink | CostateLink) -> bool:
    """Tell whether no motion takes a time between the link's."""
    if isinstance(link, TaylorLink):
        polynomial = _taylor(proof, link)
        while polynomial and link.low == 0.0 and polynomial[0] == 0:
            polynomial = polynomial[1:]  # T > 0
    elif link.free:
        if any(link.ends) or link.free not in ("start", "end") or link.high != inf:
            return False
        seen = proof if link.free == "start" else _reversed(proof)
        polynomial = _costate_polynomial(seen, link)
        return sum(c * Fraction(link.low) ** k for k, c in enumerate(polynomial)) > 0
    else:
        polynomial = _costate_polynomial(proof, link)
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


def _costate_polynomial(proof: Proof, link: CostateLink) -> Row:
    """Return the coefficients of c(T); none where the multipliers use a bound that is not there."""
    n, count = len(proof.start), len(link.cells)
    atoms = {k: list(map(Fraction, row)) for k, row in link.atoms}
    densities = {k: [list(map(Fraction, row)) for row in rows] for k, rows in link.densities}
    sizes = {len(row) for rows in (*densities.values(), list(atoms.values())) for row in rows}
    if sizes - {count} or len(link.ends) != n or not all(h > 0.0 for h in link.cells):
        return []
    cells = list(map(Fraction, link.cells))
    whole = sum(cells)
    cells = [h / whole for h in cells]
    total = [Fraction(0)] * (n + 1)
    below: list[Row] = [[] for _ in cells]
    for k in range(n):
        mass_up, mass_down = _masses(cells, atoms.get(k, []), densities.get(k, []))
        for mass, bound in ((mass_up, proof.lower[k]), (mass_down, -proof.upper[k])):
            if mass and bound == -inf:
                return []
            total[k] += mass * Fraction(bound) if mass else 0
        final = Fraction(link.ends[k])
        slopes = [_sum(below[i], [row[i] for row in densities.get(k, [])]) for i in range(count)]
        below = _integrated(slopes, cells, atoms.get(k, [Fraction(0)] * count), final)
        total[k] += final * Fraction(proof.end[k]) - below[0][0] * Fraction(proof.start[k])
    up, down = _areas(below, cells)
    total[n] -= Fraction(proof.upper[n]) * up - Fraction(proof.lower[n]) * down
    return total


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
    pending: list[tuple[Row, int]] = [
        ([value * h / len(row) for value in row], 0) for row, h in zip(rows, cells, strict=True)
    ]
    whole = sum((abs(_total(piece)) for piece, _ in pending), Fraction(0))
    enough = _UNDECIDED * whole / max(len(pending), 1)
    up = down = Fraction(0)
    while pending:
        piece, depth = pending.pop()
        above = sum((value for value in piece if value > 0), Fraction(0))
        beneath = above - _total(piece)
        if min(above, beneath) <= enough or depth == _HALVINGS:
            up, down = up + above, down + beneath
        else:
            pending += [([value / 2 for value in half], depth + 1) for half in _halves(piece)]
    return up, down


def _halves(row: Row) -> tuple[Row, Row]:
    """Return the Bernstein coefficients on both halves of an interval (de Casteljau)."""
    left, right = [], []
    while row:
        left.append(row[0])
        right.append(row[-1])
        row = [(a + b) / 2 for a, b in pairwise(row)]
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
    pending = [(first, 0)]
    while pending:
        row, depth = pending.pop()
        if min(row) > 0:
            continue
        if row[0] <= 0 or row[-1] <= 0 or depth == _DEPTH:
            return False
        pending += [(half, depth + 1) for half in _halves(row)]
    return True
