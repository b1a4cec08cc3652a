"""How the zeros, poles and gain of python-control systems, or of models, are found."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .factored_loop import Complex, FactoredLoop, Real
from .imaginary_axis import set_on_axis
from .state_space_roots import (
    Unlike,
    balanced_part,
    invariant_zeros,
    mean_power,
    passing,
    pattern_of,
    roots_of,
    stacked,
)
from .w_plane import around_one, on_w_plane, without_samples

if TYPE_CHECKING:
    import control

_ILL_POSED = 1e-13
_Found = TypeVar("_Found")


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
    [found] = factored_all([system], delay)
    if isinstance(found, Exception):
        raise found
    return found


def factored_all(systems: Sequence[Any], delay: float = 0.0) -> list[FactoredLoop | Exception]:
    """Return the factors of systems as `factored` does; in place of some what it would raise.

    Those with zeros at the same places of their matrices are looked at together.
    """
    found: list[Any] = [tried(_begun, system, delay) for system in systems]
    kinds: dict[Any, list[int]] = {}
    for k, begun in enumerate(found):
        if isinstance(begun, _Begun):
            kinds.setdefault(begun.kind, []).append(k)
    for members in kinds.values():
        for k, loop in zip(members, _loops_of([found[k] for k in members]), strict=True):
            found[k] = loop
    return found


def tried(function: Callable[..., _Found], *given: Any) -> _Found | Exception:
    """Return what a function returns, or raises, unless memory runs out."""
    try:
        return function(*given)
    except MemoryError:
        raise
    except Exception as error:
        return error


@dataclass(frozen=True, eq=False)
class _Begun:
    """A system's coefficients, in z − 1 without its samples where it is discrete."""

    parts: tuple[Any, ...]
    samples: int
    dt: float | None
    delay: float

    @property
    def kind(self) -> Any:
        """What systems that are looked at together have in common."""
        return (self.samples, *pattern_of(self.parts)) if len(self.parts) == 4 else id(self)


def _begun(system: Any, delay: float) -> _Begun:
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
    return _Begun(parts, samples, dt, delay)


def _loops_of(begun: Sequence[_Begun]) -> list[FactoredLoop | Exception]:
    """Return the loops of systems of one kind; one by one where more than numbers differ."""
    try:
        roots = _roots_of([each.parts for each in begun], begun[0].samples)
    except (Unlike, ValueError, ArithmeticError) as error:
        if len(begun) == 1:
            return [error]
        return [_loops_of([each])[0] for each in begun]
    return [tried(_finished, *each) for each in zip(begun, *roots, strict=True)]


def _roots_of(parts: Sequence[Any], samples: int) -> tuple[Any, ...]:
    """Return zeros, gains, poles, hidden ones and those of the closed loop, of each system."""
    if len(parts[0]) == 2:
        [(numerator, denominator)] = parts
        numerators, poles, gain = _of_transfer_function(numerator, denominator)
        closed = np.roots(np.polyadd(denominator, numerator)).astype(complex)
        if samples:
            [closed] = _closed_behind(stacked([_companion(numerator, denominator)]), samples)
        return [numerators], [gain], [poles], [np.empty(0, complex)], [closed]
    system = stacked(list(parts))
    closed = _closed_behind(system, samples) if samples else _closed(system)
    return *roots_of(system), closed


def _finished(
    begun: _Begun, zeros: Complex, gain: float, poles: Complex, hidden: Complex, closed: Complex
) -> FactoredLoop:
    """Return the loop, scaled in time."""
    loop = FactoredLoop(zeros, poles, float(gain), closed, hidden, samples=begun.samples)
    # Behind a delay nothing of high frequency comes back at once.
    direct = loop.zeros.size == loop.poles.size and not begun.delay and not begun.samples
    if direct and abs(1 + loop.gain) <= _ILL_POSED:
        raise ValueError(
            f"1 + L(∞) = {1 + loop.gain:.3g}: the loop is ill-posed, its closed loop has no "
            "finite gain; L(∞) other than −1 is accepted: model the roll-off of the loop, or "
            "change its gain"
        )
    if begun.delay and loop.zeros.size > loop.poles.size:
        raise ValueError(
            f"system has {loop.zeros.size} zeros and {loop.poles.size} poles: |L| grows without "
            "bound as ω → ∞, so that behind a delay no closed loop is stable; model the roll-off "
            "of the loop"
        )
    loop = _scaled(loop if begun.dt is None else on_w_plane(loop, begun.dt))
    return replace(loop, delay=begun.delay * loop.scale)


def _coefficients(system: Any) -> tuple[Real, ...]:
    if hasattr(system, "A"):
        parts: tuple[Any, ...] = (system.A, system.B[:, 0], system.C[0], system.D[0, 0])
    else:
        parts = (system.num_array[0, 0], system.den_array[0, 0])
    return tuple(np.array(part, dtype=float) for part in parts)


def _scaled(loop: FactoredLoop) -> FactoredLoop:
    """Take the geometric mean of |roots| for the unit, and set roots beside the axis on it."""
    power = mean_power(np.concatenate([loop.zeros, loop.poles, loop.closed]))
    names = ("zeros", "poles", "closed", "hidden")
    roots = {name: getattr(loop, name) * 2.0**-power for name in names}
    for name in ("zeros", "poles"):
        roots[name] = set_on_axis(roots[name][None])[0]
    gain = float(np.ldexp(loop.gain, power * (loop.zeros.size - loop.poles.size)))
    return replace(loop, **roots, gain=gain, scale=2.0**power)


def _of_transfer_function(numerator: Real, denominator: Real) -> tuple[Complex, Complex, float]:
    """Return zeros, poles and gain."""
    roots = [np.roots(part).astype(complex) for part in (numerator, denominator)]
    leading = [np.append(np.trim_zeros(part, "f"), 0.0)[0] for part in (numerator, denominator)]
    return roots[0], roots[1], float(leading[0] / leading[1])


def _closed(system: Any) -> Complex:
    """Return the roots of 1 + L, of each system."""
    a, b, c, d = balanced_part(system, passing(system))
    return invariant_zeros(a, b, c, 1 + d)[0]


def _closed_behind(system: Any, samples: int) -> Complex:
    """Return the closed loops' roots in z − 1, the loops behind samples of delay.

    They are the eigenvalues of loop and delay line, x the loop's states and p the past inputs:
    x⁺ = A·x + b·p_m, p_1⁺ = −c·x − d·p_m and p_i⁺ = p_{i−1}, less one each.
    """
    a, b, c, d = balanced_part(system, passing(system))
    n = a.shape[1]
    whole = np.zeros((len(a), n + samples, n + samples))
    whole[:, :n, :n], whole[:, :n, -1] = a, b
    whole[:, n:, n:] = np.diag(np.ones(samples - 1), -1) - np.eye(samples)
    whole[:, n, :n] -= c
    whole[:, n, -1] -= d
    return np.linalg.eigvals(whole).astype(complex)


def _companion(numerator: Real, denominator: Real) -> tuple[Real, Real, Real, Real]:
    """Return a state space (A, b, c, d) of a proper quotient."""
    n = len(denominator) - 1
    above = np.concatenate([np.zeros(n + 1 - len(numerator)), numerator]) / denominator[0]
    below = denominator / denominator[0]
    a = np.eye(n, k=-1)
    a[:1] = -below[1:]
    return a, np.eye(n, 1)[:, 0], above[1:] - above[0] * below[1:], above[0]
