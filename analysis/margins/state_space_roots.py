"""Zeros, poles and gains of state spaces with one input and one output, many at once.

A stack is of systems that are alike: A (L, n, n), b and c (L, n), d (L,), with zeros at the same
places. What is found of one does not depend on the others; where they turn out to differ in rank
or structure, `Unlike` is raised, and they have to be looked at one by one.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ...plant.balance import balanced
from .factored_loop import Complex, Real

System = tuple[Any, Any, Any, Any]


class Unlike(ValueError):
    """Systems of a stack differ in more than their coefficients."""


def stacked(systems: list[System]) -> System:
    """Return systems as a stack."""
    a, b, c, d = (np.array(part) for part in zip(*systems, strict=True))
    return a, b, c, d


def pattern_of(system: System) -> tuple[Any, ...]:
    """Return where coefficients are 0."""
    a, b, c, d = system
    return (len(a), *((part != 0).tobytes() for part in (a, b, c)), bool(d))


def roots_of(system: System) -> tuple[Complex, Real, Complex, Complex]:
    """Return zeros, gains, poles, and the poles that nothing joins to both input and output."""
    kept = passing(system)
    hidden = eigenvalues(_part(system[0], ~kept))
    system = balanced_part(system, kept)
    poles = eigenvalues(system[0])
    return *_refined(system, poles, *invariant_zeros(*system)), poles, hidden


def passing(system: System) -> npt.NDArray[np.bool_]:
    """Mask of the states that a chain of coefficients joins to both input and output."""
    a, b, c, _ = system
    joined = _joined(a.shape[1], (a[0] != 0).tobytes())
    return np.asarray((joined @ (b[0] != 0)) & ((c[0] != 0) @ joined))


def balanced_part(system: System, kept: npt.NDArray[np.bool_]) -> System:
    """Return some states in units, powers of two, that balance [[A, b], [c, d]]."""
    a, b, c, d = system
    whole = np.concatenate(
        [
            np.concatenate([_part(a, kept), b[:, kept, None]], axis=2),
            np.concatenate([c[:, None, kept], d[:, None, None]], axis=2),
        ],
        axis=1,
    )
    matched = np.array([balanced(each)[0] for each in whole])
    return matched[:, :-1, :-1], matched[:, :-1, -1], matched[:, -1, :-1], d


def invariant_zeros(a: Any, b: Any, c: Any, d: Any) -> tuple[Complex, Real]:
    """Return the zeros and high-frequency gain of (A, B, C, D), all infinite zeros deflated.

    While D = 0, zero output holds the state that C sees at zero; without it the output of the
    remaining system is that state's derivative. Emami-Naeini and Van Dooren, Automatica 18
    (1982) 415-430, for one input and output.
    """
    # StateSpace.zeros returns infinite zeros as finite ones from (s + 2)/(s + 1)³/(s + 30), turned.
    gain: Any = np.ones(len(d))
    floor_c = floor_d = np.zeros(len(d))
    while _common(abs(d) <= floor_d):
        if _common(_norm(c) <= floor_c):
            return np.empty((len(d), 0), complex), np.zeros(len(d))
        turn = np.linalg.qr(c[:, :, None], mode="complete")[0]
        back = turn.transpose(0, 2, 1)
        gain = gain * (c[:, None] @ turn)[:, 0, 0]
        a, b = back @ a @ turn, (back @ b[:, :, None])[..., 0]
        floor_c, floor_d = 1e-13 * _norm(a), 1e-13 * _norm(b)
        a, b, c, d = a[:, 1:, 1:], b[:, 1:], a[:, 0, 1:], b[:, 0]
    return eigenvalues(a - b[:, :, None] * c[:, None] / d[:, None, None]), gain * d


def eigenvalues(matrices: Any) -> Complex:
    """Eigenvalues, block by block of states that follow one another both ways, (L, n)."""
    size = matrices.shape[1]
    found = np.empty((len(matrices), size), complex)
    for rows, pattern in _groups([each.tobytes() for each in matrices != 0]):
        some, place = matrices[rows], 0
        for block in _blocks(size, pattern):
            found[rows, place : place + block.size] = _block_eigenvalues(_part(some, block))
            place += block.size
    return found


def _block_eigenvalues(matrices: Any) -> Complex:
    """Eigenvalues, those at 0 exact: the null space is split off before the rest is solved."""
    if matrices.shape[1] == 1:
        return np.asarray(matrices[:, 0].astype(complex))
    given = matrices
    # Given rows count each by itself; what a split leaves is rounded by the largest of them.
    rows = np.linalg.norm(matrices, axis=2, keepdims=True)
    scaled, floor = matrices / np.where(rows > 0, rows, 1.0), np.ones(len(matrices))
    at_zero, share = 0, 8 * matrices.shape[1] * np.finfo(float).eps
    while matrices.shape[1]:
        _, sizes, right = np.linalg.svd(scaled)
        ranks = (sizes > share * floor[:, None]).sum(axis=1)
        rank = int(ranks[0])
        if (ranks != rank).any():
            return _by_rank(given, ranks)
        if rank == matrices.shape[1]:
            break
        at_zero += matrices.shape[1] - rank
        floor = _norm(matrices)
        turned = right @ matrices @ right.transpose(0, 2, 1)
        scaled = matrices = turned[:, :rank, :rank]
    found = np.linalg.eigvals(matrices).astype(complex)
    return np.concatenate([found, np.zeros((len(matrices), at_zero))], axis=1)


def _by_rank(matrices: Any, ranks: Any) -> Complex:
    found = np.empty(matrices.shape[:2], complex)
    for rows, _ in _groups(ranks.tolist()):
        found[rows] = _block_eigenvalues(matrices[rows])
    return found


def _groups(kinds: list[Any]) -> list[tuple[list[int], Any]]:
    """Return the numbers of all that are of one kind, and the kind."""
    found: dict[Any, list[int]] = {}
    for k, kind in enumerate(kinds):
        found.setdefault(kind, []).append(k)
    return [(rows, kind) for kind, rows in found.items()]


def _refined(system: System, poles: Complex, zeros: Complex, gain: Real) -> tuple[Complex, Real]:
    """Zeros after Newton steps on L(s) itself, and the gain that meets L at one point.

    Deflation loses digits where the states are badly scaled; solving (sI − A)x = B loses fewer.
    """
    if _common(gain == 0) or not poles.size:
        return zeros, gain
    free = _apart(zeros, poles)
    beyond = 1.0 + 2.0 * abs(poles).max(axis=1, keepdims=True)
    moving = np.where(free, zeros, beyond)
    value, slope = _response(system, moving)
    for _ in range(2):
        with np.errstate(all="ignore"):
            trial = moving - value / slope
        trial = np.where(free & _apart(trial, poles), trial, moving)
        tried = _response(system, trial)
        better = abs(tried[0]) < abs(value)
        moving, value, slope = (
            np.where(better, new, old)
            for new, old in zip((trial, *tried), (moving, value, slope), strict=True)
        )
    zeros = np.where(free, moving, zeros)
    if _common(system[-1] != 0):
        return zeros, gain
    at, found = _well_conditioned(system, poles)
    logs = _sum(np.log(at[:, None] - poles)) - _sum(np.log(at[:, None] - zeros))
    return zeros, (found * np.exp(logs)).real


def _well_conditioned(system: System, poles: Complex) -> tuple[Complex, Complex]:
    """Return the point s among the poles' sizes where rounding of A moves L(s) least, and L(s).

    To first order by ε·|c·(sI − A)⁻¹|·(|s|·I + |A|)·|(sI − A)⁻¹·b|, entry by entry.
    """
    a, b, c, d = system
    points = _filled([_sizes(row) for row in poles]) * np.exp(1j)
    identity = np.eye(a.shape[1])
    inverse = np.linalg.inv(points[..., None, None] * identity - a[:, None])
    behind = inverse @ b[:, None, :, None]
    ahead = c[:, None, None, :] @ inverse
    moved = abs(points)[..., None, None] * identity + abs(a)[:, None]
    values = (c[:, None, None, :] @ behind)[..., 0, 0] + d[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = (abs(ahead) @ moved @ abs(behind))[..., 0, 0] / abs(values)
    best = np.argmin(np.where(np.isnan(spread), np.inf, spread), axis=1)
    rows = np.arange(len(a))
    return points[rows, best], values[rows, best]


def _sizes(poles: Complex) -> Real:
    """Return powers of two next to all |poles|, each once, then that next to their mean."""
    powers = np.round(np.log2(abs(poles[poles != 0])))
    return 2.0 ** np.append(np.unique(powers), mean_power(poles))


def mean_power(roots: Complex) -> int:
    """Power of two next to the geometric mean of |roots|: dividing by it rounds nothing."""
    size = abs(roots[roots != 0])
    return round(float(np.log2(size).mean())) if size.size else 0


def _filled(rows: list[Real]) -> Real:
    """Return rows of different lengths as one array, their last number at their ends."""
    filled = np.empty((len(rows), max(row.size for row in rows)))
    for k, row in enumerate(rows):
        filled[k, : row.size], filled[k, row.size :] = row, row[-1]
    return filled


def _apart(roots: Complex, poles: Complex) -> npt.NDArray[np.bool_]:
    """Mask of nonzero finite roots where L is finite: beside a pole that they cancel it is 0/0."""
    with np.errstate(invalid="ignore"):
        gaps = abs(roots[:, :, None] - poles[:, None]).min(axis=2)
        return np.asarray((gaps > 1e-6 * abs(roots)) & (roots != 0))


def _response(system: System, s: Complex) -> tuple[Complex, Complex]:
    """L(s) and L'(s), (L, K)."""
    a, b, c, d = system
    shifted = s[..., None, None] * np.eye(a.shape[1]) - a[:, None]
    states = np.linalg.solve(
        shifted, np.broadcast_to(b[:, None, :, None], (*s.shape, *b.shape[1:], 1))
    )
    row = c[:, None, None, :]
    slopes = row @ np.linalg.solve(shifted, states)
    return (row @ states)[..., 0, 0] + d[:, None], -slopes[..., 0, 0]


def _common(conditions: Any) -> bool:
    """Return what is so of all systems, or of none."""
    first = bool(conditions[0])
    if (conditions != first).any():
        raise Unlike
    return first


def _norm(parts: Any) -> Real:
    """Return the norm of each matrix or vector of a stack."""
    flat = parts.reshape(len(parts), 1, -1)
    return np.asarray(np.sqrt((flat @ flat.transpose(0, 2, 1))[:, 0, 0]))


def _sum(terms: Complex) -> Complex:
    """Return the sums of rows, one term after the other."""
    none = np.zeros((len(terms), 1), complex)
    return np.add.accumulate(np.concatenate([none, terms], axis=1), axis=1)[:, -1]


@lru_cache(maxsize=256)
def _joined(size: int, pattern: bytes) -> npt.NDArray[np.bool_]:
    """Whether state i follows state j, itself included, through any chain of coefficients."""
    joined = np.frombuffer(pattern, bool).reshape(size, size) | np.eye(size, dtype=bool)
    for _ in range(size.bit_length()):
        joined = joined @ joined
    return np.asarray(joined)


@lru_cache(maxsize=256)
def _blocks(size: int, pattern: bytes) -> list[npt.NDArray[np.intp]]:
    """Return states that follow one another both ways, block by block, the last first."""
    joined = _joined(size, pattern)
    mutual = joined & joined.T
    first = mutual.argmax(axis=1) if size else np.empty(0)
    return [np.flatnonzero(block) for block in mutual[first == np.arange(size)][::-1]]


def _part(matrices: Any, kept: Any) -> Any:
    return matrices[:, kept][:, :, kept]
