"""How the zeros, poles and gain of a python-control system are found."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...plant.balance import balanced
from .factored_loop import Complex, FactoredLoop, Real
from .imaginary_axis import set_on_axis
from .w_plane import around_one, on_w_plane, without_samples

if TYPE_CHECKING:
    import control

_ILL_POSED = 1e-13


def factored(
    system: "control.StateSpace | control.TransferFunction", delay: float = 0.0
) -> FactoredLoop:
    """Return the factors of a system with one input and one output, scaled in time.

    Parameters
    ----------
    system : control.StateSpace or control.TransferFunction
    delay : float, optional
        In seconds, behind a system in continuous time.

    Raises
    ------
    ValueError
        If a coefficient is not finite, 1 + L vanishes as ω → ∞ or z → ∞, or a discrete system,
        or one with a delay, has more zeros than poles.
    """
    parts = _coefficients(system)
    if not all(np.isfinite(part).all() for part in parts):
        raise ValueError(
            "system has coefficients that are nan or inf; loop_margins takes finite ones: "
            "check the parameters it was built from"
        )
    dt, samples = (float(system.dt) if system.isdtime(strict=True) else None), 0
    if dt is not None:
        parts, samples = without_samples(*parts)
        parts = around_one(*parts)
    loop = _of_state_space(*parts) if len(parts) == 4 else _of_transfer_function(*parts)
    closed = _closed_behind(parts, samples) if samples else _closed(parts)
    loop = replace(loop, closed=closed, samples=samples)
    # Behind a delay nothing of high frequency comes back at once.
    direct = loop.zeros.size == loop.poles.size and not delay and not samples
    if direct and abs(1 + loop.gain) <= _ILL_POSED:
        raise ValueError(
            f"1 + L(∞) = {1 + loop.gain:.3g}: the loop is ill-posed, its closed loop has no "
            "finite gain; L(∞) other than −1 is accepted: model the roll-off of the loop, or "
            "change its gain"
        )
    if delay and loop.zeros.size > loop.poles.size:
        raise ValueError(
            f"system has {loop.zeros.size} zeros and {loop.poles.size} poles: |L| grows without "
            "bound as ω → ∞, so that behind a delay no closed loop is stable; model the roll-off "
            "of the loop"
        )
    loop = _scaled(loop if dt is None else on_w_plane(loop, dt))
    return replace(loop, delay=delay * loop.scale)


def _coefficients(system: Any) -> tuple[Real, ...]:
    if hasattr(system, "A"):
        parts: tuple[Any, ...] = (system.A, system.B[:, 0], system.C[0], system.D[0, 0])
    else:
        parts = (system.num_array[0, 0], system.den_array[0, 0])
    return tuple(np.array(part, dtype=float) for part in parts)


def _scaled(loop: FactoredLoop) -> FactoredLoop:
    """Take the geometric mean of |roots| for the unit, and set roots beside the axis on it."""
    power = _mean_power(np.concatenate([loop.zeros, loop.poles, loop.closed]))
    names = ("zeros", "poles", "closed", "hidden")
    roots = {name: getattr(loop, name) * 2.0**-power for name in names}
    for name in ("zeros", "poles"):
        roots[name] = set_on_axis(roots[name][None])[0]
    gain = float(np.ldexp(loop.gain, power * (loop.zeros.size - loop.poles.size)))
    return replace(loop, **roots, gain=gain, scale=2.0**power)


def _mean_power(roots: Complex) -> int:
    """Power of two next to the geometric mean of |roots|: dividing by it rounds nothing."""
    size = abs(roots[roots != 0])
    return round(float(np.log2(size).mean())) if size.size else 0


def _of_transfer_function(numerator: Real, denominator: Real) -> FactoredLoop:
    roots = [np.roots(part).astype(complex) for part in (numerator, denominator)]
    leading = [np.append(np.trim_zeros(part, "f"), 0.0)[0] for part in (numerator, denominator)]
    gain = float(leading[0] / leading[1])
    return FactoredLoop(roots[0], roots[1], gain, *(np.empty(0, complex),) * 2)


def _closed(parts: tuple[Real, ...]) -> Complex:
    """Return the roots of 1 + L."""
    if len(parts) == 2:
        return np.roots(np.polyadd(parts[1], parts[0])).astype(complex)
    a, b, c, d = parts
    kept = _passing(a, b, c)
    return _invariant_zeros(*_balanced(a[np.ix_(kept, kept)], b[kept], c[kept], d), 1 + d)[0]


def _closed_behind(parts: tuple[Real, ...], samples: int) -> Complex:
    """Return the closed loop's roots in z − 1, the loop behind samples of delay.

    They are the eigenvalues of loop and delay line, x the loop's states and p the past inputs:
    x⁺ = A·x + b·p_m, p_1⁺ = −c·x − d·p_m and p_i⁺ = p_{i−1}, less one each.
    """
    a, b, c, d = parts if len(parts) == 4 else _companion(*parts)
    kept = _passing(a, b, c)
    a, b, c = _balanced(a[np.ix_(kept, kept)], b[kept], c[kept], d)
    n = len(a)
    whole = np.zeros((n + samples, n + samples))
    whole[:n, :n], whole[:n, -1] = a, b
    whole[n:, n:] = np.diag(np.ones(samples - 1), -1) - np.eye(samples)
    whole[n, :n] -= c
    whole[n, -1] -= d
    return np.linalg.eigvals(whole).astype(complex)


def _companion(numerator: Real, denominator: Real) -> tuple[Real, Real, Real, Real]:
    """Return a state space (A, b, c, d) of a proper quotient."""
    n = len(denominator) - 1
    above = np.concatenate([np.zeros(n + 1 - len(numerator)), numerator]) / denominator[0]
    below = denominator / denominator[0]
    a = np.eye(n, k=-1)
    a[:1] = -below[1:]
    return a, np.eye(n, 1)[:, 0], above[1:] - above[0] * below[1:], above[0]


def _of_state_space(a: Real, b: Real, c: Real, d: Real) -> FactoredLoop:
    kept = _passing(a, b, c)
    hidden = _eigenvalues(a[np.ix_(~kept, ~kept)])
    a, b, c = _balanced(a[np.ix_(kept, kept)], b[kept], c[kept], d)
    poles = _eigenvalues(a)
    zeros, gain = _refined((a, b, c, d), poles, *_invariant_zeros(a, b, c, d))
    return FactoredLoop(zeros, poles, gain, np.empty(0, complex), hidden)


def _passing(a: Real, b: Real, c: Real) -> npt.NDArray[np.bool_]:
    """Mask of the states that a chain of coefficients joins to both input and output."""
    joined = _joined(a)
    return np.asarray((joined @ (b != 0)) & ((c != 0) @ joined))


def _joined(a: Any) -> npt.NDArray[np.bool_]:
    """Whether state i follows state j, itself included, through any chain of coefficients."""
    joined = (a != 0) | np.eye(len(a), dtype=bool)
    for _ in range(len(a).bit_length()):
        joined = joined @ joined
    return np.asarray(joined)


def _balanced(a: Any, b: Any, c: Any, d: Any) -> tuple[Any, Any, Any]:
    """Scale the states by powers of two so that rows and columns of [[A, B], [C, D]] match."""
    whole = np.block([[a, b[:, None]], [c[None, :], d]])
    matched = balanced(whole)[0]
    return matched[:-1, :-1], matched[:-1, -1], matched[-1, :-1]


def _invariant_zeros(a: Any, b: Any, c: Any, d: Any) -> tuple[Complex, float]:
    """Return the zeros and high-frequency gain of (A, B, C, D), all infinite zeros deflated.

    While D = 0, zero output holds the state that C sees at zero; without it the output of the
    remaining system is that state's derivative. Emami-Naeini and Van Dooren, Automatica 18
    (1982) 415-430, for one input and output.
    """
    # StateSpace.zeros returns infinite zeros as finite ones from (s + 2)/(s + 1)³/(s + 30), turned.
    gain: Any = 1.0
    floor_c = floor_d = 0.0
    while abs(d) <= floor_d:
        if np.linalg.norm(c) <= floor_c:
            return np.empty(0, complex), 0.0
        turn = np.linalg.qr(c[:, None], mode="complete")[0]
        gain = gain * (c @ turn)[0]
        a, b = turn.T @ a @ turn, turn.T @ b
        floor_c, floor_d = (1e-13 * float(np.linalg.norm(part)) for part in (a, b))
        a, b, c, d = a[1:, 1:], b[1:], a[0, 1:], b[0]
    return _eigenvalues(a - np.outer(b, c) / d), float(gain * d)


def _eigenvalues(matrix: Any) -> Complex:
    """Eigenvalues, block by block of states that follow one another both ways."""
    joined = _joined(matrix)
    mutual = joined & joined.T
    first = mutual.argmax(axis=1) if mutual.size else np.empty(0)
    blocks = mutual[first == np.arange(len(matrix))][::-1]
    parts = [_block_eigenvalues(matrix[np.ix_(block, block)]) for block in blocks]
    return np.concatenate([*parts, np.empty(0)]).astype(complex)


def _block_eigenvalues(matrix: Any) -> Complex:
    """Eigenvalues, those at 0 exact: the null space is split off before the rest is solved."""
    if matrix.size == 1:
        return np.asarray(matrix[0].astype(complex))
    # Given rows count each by itself; what a split leaves is rounded by the largest of them.
    rows = np.linalg.norm(matrix, axis=1, keepdims=True)
    scaled, floor = matrix / np.where(rows > 0, rows, 1.0), 1.0
    at_zero, share = 0, 8 * len(matrix) * np.finfo(float).eps
    while matrix.size:
        _, sizes, right = np.linalg.svd(scaled)
        rank = int(np.sum(sizes > share * floor))
        if rank == len(sizes):
            break
        at_zero += len(sizes) - rank
        floor = float(np.linalg.norm(matrix))
        scaled = matrix = (right @ matrix @ right.T)[:rank, :rank]
    return np.concatenate([np.linalg.eigvals(matrix), np.zeros(at_zero)]).astype(complex)


def _refined(system: Any, poles: Complex, zeros: Complex, gain: float) -> tuple[Complex, float]:
    """Zeros after Newton steps on L(s) itself, and the gain that meets L at one point.

    Deflation loses digits where the states are badly scaled; solving (sI − A)x = B loses fewer.
    """
    if gain == 0 or not poles.size:
        return zeros, gain
    free = _apart(zeros, poles)
    moving = zeros[free]
    for _ in range(2):
        value, slope = _response(system, moving)
        with np.errstate(all="ignore"):
            trial = moving - value / slope
        trial = np.where(_apart(trial, poles), trial, moving)
        moving = np.where(abs(_response(system, trial)[0]) < abs(value), trial, moving)
    zeros = np.concatenate([moving, zeros[~free]])
    if system[-1] != 0:
        return zeros, gain
    at, found = _well_conditioned(system, poles)
    logs = np.log(at - poles).sum() - np.log(at - zeros).sum()
    return zeros, float((found * np.exp(logs)).real)


def _well_conditioned(system: Any, poles: Complex) -> tuple[complex, complex]:
    """Return the point s among the poles' sizes where rounding of A moves L(s) least, and L(s).

    To first order by ε·|c·(sI − A)⁻¹|·(|s|·I + |A|)·|(sI − A)⁻¹·b|, entry by entry.
    """
    a, b, c, d = system
    sizes = np.unique(2.0 ** np.round(np.log2(abs(poles[poles != 0]))))
    points = np.append(sizes, 2.0 ** _mean_power(poles)) * np.exp(1j)
    identity = np.eye(b.size)
    inverse = np.linalg.inv(points[:, None, None] * identity - a)
    behind, ahead = inverse @ b, c @ inverse
    moved = abs(points)[:, None, None] * identity + abs(a)
    values = behind @ c + d
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.einsum("ki,kij,kj->k", abs(ahead), moved, abs(behind)) / abs(values)
    best = int(np.argmin(np.where(np.isnan(spread), np.inf, spread)))
    return complex(points[best]), complex(values[best])


def _apart(roots: Complex, poles: Complex) -> npt.NDArray[np.bool_]:
    """Mask of nonzero finite roots where L is finite: beside a pole that they cancel it is 0/0."""
    with np.errstate(invalid="ignore"):
        gaps = abs(roots[:, None] - poles).min(axis=1)
        return np.asarray((gaps > 1e-6 * abs(roots)) & (roots != 0))


def _response(system: Any, s: Complex) -> tuple[Complex, Complex]:
    """L(s) and L'(s)."""
    a, b, c, d = system
    shifted = s[:, None, None] * np.eye(b.size) - a
    states = np.linalg.solve(shifted, np.broadcast_to(b[:, None], (s.size, b.size, 1)))
    return states[..., 0] @ c + d, -(np.linalg.solve(shifted, states)[..., 0] @ c)
