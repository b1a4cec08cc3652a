"""What a proven bound hangs on, from its proof alone: dT/d(bound), by rational numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from math import isfinite

from .proof import Numbers, Proof, Slopes
from .proof_check import polynomial_of

_SAME = 5e-3  # relative: where c hardly crosses zero the floats that were told are no nearer
_LITTLE = 1e-6  # of a sensitivity, or of what a bound's slope makes of one


def tells_truly(proof: Proof, slopes: Slopes, sensitivities: Numbers) -> bool:
    """Tell whether these are the slopes of a proof, and its sensitivities those of the slopes."""
    proven = proven_slopes(proof) or slopes
    more = len(slopes) - len(proven)
    if more < 0 or len(sensitivities) != len(slopes) - 1:
        return False
    proven = (*proven, *[(0.0, 0.0)] * more)
    bounds = [*zip(proof.lower, proof.upper, strict=True), *[(0.0, 0.0)] * more]
    shares = [
        sum(slope * bound for slope, bound in zip(*each, strict=True) if slope) / proof.lower_bound
        for each in zip(slopes, bounds, strict=True)
    ]
    sides = zip(_all(slopes), _all(proven), _all(bounds), strict=True)
    return all(
        abs(told - slope) <= _SAME * abs(slope)
        or abs(told - slope) * abs(bound) <= _LITTLE * proof.lower_bound * bool(bound)
        for told, slope, bound in sides
    ) and all(
        abs(told - share) <= _SAME * abs(share) + _LITTLE
        for told, share in zip(sensitivities, shares[1:], strict=True)
    )


def _all(pairs: Iterable[tuple[float, float]]) -> Numbers:
    return tuple(side for pair in pairs for side in pair)


def proven_slopes(proof: Proof) -> Slopes:
    """Return dT/dlo_k and dT/dhi_k of the root T of the last link's c(T), position first.

        dT/db = −(∂c/∂b)/(dc/dT);   c is linear in each bound b

    Zero where there is no bound; empty where c has no slope at T.
    """
    time = Fraction(proof.lower_bound)
    now = polynomial_of(proof, proof.links[-1])
    slope = sum(k * c * time ** (k - 1) for k, c in enumerate(now) if k)
    if not slope:
        return ()

    def of(sides: Numbers, k: int, upper: bool) -> float:
        if not isfinite(sides[k]):
            return 0.0
        other = 0.0 if sides[k] else 1.0
        changed = (*sides[:k], other, *sides[k + 1 :])
        seen = replace(proof, upper=changed) if upper else replace(proof, lower=changed)
        then = polynomial_of(seen, proof.links[-1])
        gained = sum((b - a) * time**i for i, (a, b) in enumerate(zip(now, then, strict=True)))
        return float(-gained / slope / (Fraction(other) - Fraction(sides[k])))

    return tuple(
        (of(proof.lower, k, False), of(proof.upper, k, True)) for k in range(len(proof.upper))
    )
