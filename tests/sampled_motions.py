"""Motions with an input constant on equal cells, bounds kept at their edges: by linear programs.

An oracle that shares nothing with the planners. Between the edges bounds may be broken, so that
it errs on the fast side by a little; by its coarse switches it errs on the slow side.
"""

from math import factorial, inf

import numpy as np
from scipy.optimize import linprog


def least_share(start, end, limits, duration, cells=120, via=()):
    """Return the smallest share of the highest bound with which a motion exists; inf for none.

    `via` are pairs (time, position) besides both states.
    """
    n, dt = limits.order, duration / cells
    edges = dt * np.arange(cells + 1)
    since = np.maximum(edges[:, None] - edges, 0.0)
    bounds = [limits.bounds(k) for k in range(n + 1)]
    unit = max(-bounds[n][0], bounds[n][1])
    rows = [
        unit * (since[:, :-1] ** (n - k) - since[:, 1:] ** (n - k)) / factorial(n - k)
        for k in range(n)
    ]
    begin, finish = (np.array([*np.atleast_1d(x), *[0.0] * n])[:n] for x in (start, end))
    free = [
        sum(begin[q] * edges ** (q - k) / factorial(q - k) for q in range(k, n)) for k in range(n)
    ]
    at = [round(time / dt) for time, _ in via]
    equal = np.vstack([rows[0][at], *[rows[k][-1:] for k in range(n)]])
    places = [position - free[0][i] for i, (_, position) in zip(at, via, strict=True)]
    sides = np.array([*places, *[finish[k] - free[k][-1] for k in range(n)]])
    less, most = [np.zeros((0, cells))], [np.zeros(0)]
    for k in range(n):
        for sign, side in ((1.0, bounds[k][1]), (-1.0, -bounds[k][0])):
            if side < inf:
                less.append(sign * rows[k])
                most.append(side - sign * free[k])
    less, most = np.vstack(less), np.concatenate(most)
    scale = np.maximum(np.abs(less).max(axis=1, initial=0.0), 1e-300)
    less, most = less / scale[:, None], most / scale
    share = np.zeros((len(less) + 2 * cells, 1))
    share[len(less) :, 0] = np.repeat([-bounds[n][1] / unit, bounds[n][0] / unit], cells)
    whole = np.abs(equal).max(axis=1)
    result = linprog(
        np.append(np.zeros(cells), 1.0),
        A_ub=np.hstack([np.vstack([less, np.eye(cells), -np.eye(cells)]), share]),
        b_ub=np.append(most, np.zeros(2 * cells)) + 1e-9,
        A_eq=np.hstack([equal / whole[:, None], np.zeros((len(equal), 1))]),
        b_eq=sides / whole,
        bounds=[(None, None)] * cells + [(0.0, None)],
    )
    return float(result.x[-1]) if result.status == 0 else inf
