"""Motions and proofs of minimum time in 50 digits, from their numbers alone: no code in common."""

from __future__ import annotations

import json
from itertools import pairwise
from math import comb, factorial, inf

import mpmath
import numpy as np
from mpmath import mpf

DIGITS = 50
HALVINGS = 40
NEGLIGIBLE = mpf(10) ** -13


def feasible_duration(move, start, end, limits):
    """Return a duration that a motion certainly has: its own, its end made exact.

    From rest to rest what it exceeds a bound by, some 1e-15, is made up for by slowing it down;
    else it must exceed none.
    """
    n = limits.order
    with mpmath.workdps(DIGITS):
        steps = [mpf(float(h)) for h in move.durations]
        inputs = [mpf(float(state[n])) for state in move.states]
        begin, finish = ([mpf(float(x)) for x in state] for state in (start, end))
        left = [mpmath.fsum(steps[i:]) for i in range(len(steps) + 1)]
        effects = mpmath.matrix(
            [
                [(a ** (n - k) - b ** (n - k)) / factorial(n - k)
                 for a, b in pairwise(left)]
                for k in range(n)
            ]
        )  # fmt: skip
        missed = mpmath.matrix(finish) - mpmath.matrix(_run(begin, steps, inputs)[-1])
        change = effects.T * mpmath.lu_solve(effects * effects.T, missed)
        exact = [u + du for u, du in zip(inputs, change, strict=True)]
        states = _run(begin, steps, exact)
        size = max(map(abs, inputs))
        assert max(map(abs, change)) <= 1e-9 * size
        missed = max(abs(a - b) for a, b in zip(states[-1], finish, strict=True))
        assert missed <= mpf(10) ** (10 - DIGITS) * max(map(abs, (*begin, *finish)))
        worst = max(
            _excess([*state[k:], u], h, *limits.bounds(k))
            for state, u, h in zip(states, exact, steps, strict=False)
            for k in range(n + 1)
        )
        at_rest = not any((*start[1:], *end[1:])) and limits.plain
        assert worst <= (1e-11 if at_rest else 1e-14)
        return mpmath.fsum(steps) * (1 + worst)


def _run(start, steps, inputs):
    """Return the states at the start of every piece, and the end."""
    states, n = [start], len(start)
    for h, u in zip(steps, inputs, strict=True):
        row = [*states[-1], u]
        states.append(
            [mpmath.fsum(row[k + i] * h**i / factorial(i) for i in range(n - k + 1))
             for k in range(n)]
        )  # fmt: skip
    return states


def _excess(taylor, h, low, high):
    """Return a bound on what a polynomial exceeds its bounds by, relative to the bound."""
    d = len(taylor) - 1
    power = [value * h**i / factorial(i) for i, value in enumerate(taylor)]
    row = [
        mpmath.fsum(mpf(comb(j, i)) / comb(d, i) * power[i] for i in range(j + 1))
        for j in range(d + 1)
    ]
    pending, worst = [(row, 0)], mpf(0)
    while pending:
        row, depth = pending.pop()
        over = max(_beyond(max(row), high), _beyond(-min(row), -low))
        if over <= NEGLIGIBLE or depth == HALVINGS:
            worst = max(worst, over)
            continue
        left, right = [], []
        while row:
            left.append(row[0])
            right.append(row[-1])
            row = [(a + b) / 2 for a, b in pairwise(row)]
        pending += [(left, depth + 1), (right[::-1], depth + 1)]
    return worst


def _beyond(value, bound):
    if bound == inf or value <= bound:
        return mpf(0)
    return (value - mpf(bound)) / (abs(mpf(bound)) if bound else 1)


def is_proven(path, *, slack=1e-12) -> bool:
    """Tell whether a saved certificate's links exclude what they say, at some durations of each."""
    proof = json.loads(path.read_text())["proof"]
    with mpmath.workdps(DIGITS):
        reached = 0.0
        rest = not any((*proof["start"][1:], *proof["end"][1:]))
        for link in proof["links"]:
            if not (rest or link["low"] <= reached):
                return False
            width = link["high"] - link["low"]
            times = [link["low"] + share * width for share in (0.001, 0.5, 1.0 - slack)]
            if not all(c > 0 for c in _values(proof, link, times)):
                return False
            reached = max(reached, link["high"])
        return reached >= proof["lower_bound"]


def _values(proof, link, times):
    """Return c(T) at some durations."""
    n = len(proof["start"])
    start, end = ([mpf(x) for x in proof[name]] for name in ("start", "end"))
    if link["kind"] == "TaylorLink":
        k, m, sign = link["derivative"], link["remainder"], link["sign"]
        bound = sign * mpf(proof["upper" if sign > 0 else "lower"][m])
        return [
            sign * (end[k] - mpmath.fsum(start[q] * mpf(t) ** (q - k) / factorial(q - k)
                                         for q in range(k, m)))
            - bound * mpf(t) ** (m - k) / factorial(m - k)
            for t in times
        ]  # fmt: skip
    cells, ends, atoms, densities = _whole(link, n)
    length = mpmath.fsum(cells)
    terms, below = [], [[] for _ in cells]
    for k in range(n):
        masses = list(atoms[k])
        for h, row in zip(cells, densities[k], strict=True):
            masses += [h * value / len(row) for value in row]
        after = ends[k]
        for i in reversed(range(len(cells))):
            slope = _sum(below[i], _powers(densities[k][i], cells[i]))
            below[i] = [after + atoms[k][i], *(c / (j + 1) for j, c in enumerate(slope))]
            after = _at(below[i], cells[i])
        terms.append(ends[k] * end[k] - after * start[k] + _paid(proof, k, masses))
    areas = [-area for row, h in zip(below, cells, strict=True) for area in _areas(row, h)]
    terms.append(_paid(proof, n, areas))
    return [mpmath.fsum(c * (mpf(t) / length) ** k for k, c in enumerate(terms)) for t in times]


def _paid(proof, k, masses):
    """Return lo·(positive masses) − hi·(negative ones)."""
    up, down = (mpmath.fsum(m for m in masses if s * m > 0) for s in (1, -1))
    low, high = proof["lower"][k], proof["upper"][k]
    return (up * mpf(low) if up else mpf(0)) + (down * mpf(high) if down else mpf(0))


def _whole(link, n):
    """Return cells, λ_k, atoms at the right ends of cells, densities (rows by cell) for each k."""
    cells = [mpf(h) for h in link["cells"]]
    none = [mpf(0)] * len(cells)
    given = {k: [mpf(x) for x in row] for k, row in link["atoms"]}
    rows = {k: [list(map(mpf, each)) for each in zip(*rows, strict=True)]
            for k, rows in link["densities"]}  # fmt: skip
    atoms = [given.get(k, none) for k in range(n)]
    densities = [rows.get(k, [[mpf(0)] for _ in cells]) for k in range(n)]
    ends = [mpf(x) for x in link["ends"]]
    if link["kind"] == "CostateLink":
        return cells, ends, atoms, densities
    cruise = mpf(link["cruise"])
    first, between = ends[0], [cruise] if cruise else []
    signs = [(-1) ** (k + 1) for k in range(n)]
    back = [[s * a for a in row[::-1]] for s, row in zip(signs, atoms, strict=True)]
    middle = [
        [*row, other[0]] if cruise else [*row[:-1], row[-1] + other[0]]
        for row, other in zip(atoms, back, strict=True)
    ]
    whole = [[*row, *other[1:], mpf(0)] for row, other in zip(middle, back, strict=True)]
    held = [[[-first if k == 1 else mpf(0)]] * len(between) for k in range(n)]
    densities = [
        [*row, *held[k], *([s * x for x in each[::-1]] for each in row[::-1])]
        for k, (s, row) in enumerate(zip(signs, densities, strict=True))
    ]
    return [*cells, *between, *cells[::-1]], _begin(cells, ends, atoms, densities), whole, densities


def _begin(cells, ends, atoms, densities):
    """Return λ_k = (−1)^k·p_k(0) of mirrored multipliers."""
    found, below = [], [[] for _ in cells]
    for k, after in enumerate(ends):
        for i in reversed(range(len(cells))):
            slope = _sum(below[i], _powers(densities[k][i], cells[i]))
            below[i] = [after + atoms[k][i], *(c / (j + 1) for j, c in enumerate(slope))]
            after = _at(below[i], cells[i])
        found.append((-1) ** k * after)
    return found


def _powers(bernstein, h):
    """Return the coefficients of powers of the time that is left in a cell."""
    row, d = bernstein[::-1], len(bernstein) - 1
    return [
        comb(d, i) * mpmath.fsum((-1) ** (i - j) * comb(i, j) * row[j] for j in range(i + 1)) / h**i
        for i in range(d + 1)
    ]


def _sum(left, right):
    size = max(len(left), len(right))
    left, right = (list(row) + [mpf(0)] * (size - len(row)) for row in (left, right))
    return [a + b for a, b in zip(left, right, strict=True)]


def _at(row, v):
    value = mpf(0)
    for coefficient in reversed(row):
        value = value * v + coefficient
    return value


def _areas(row, h):
    """Return the integrals between roots; roots in double precision are good to their square."""
    scaled = np.array([float(c * h**i) for i, c in enumerate(row)])
    roots = np.roots(np.trim_zeros(scaled[::-1], "f")) if scaled.any() else np.empty(0)
    real = roots.real[np.abs(roots.imag) < 1e-6]
    inside = [mpf(float(v)) * h for v in np.sort(real[(real > 0.0) & (real < 1.0)])]
    rising = [mpf(0), *(c / (i + 1) for i, c in enumerate(row))]
    values = [_at(rising, v) for v in (mpf(0), *inside, h)]
    return [b - a for a, b in pairwise(values)]
