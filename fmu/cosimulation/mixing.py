"""What a block is given from what all blocks show, exact in integers of 64 bits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


def mix(given: Any, weights: Any, seen: Any, wide: Sequence[int]) -> Any:
    """Return given + weights @ seen; objects, with ints at the places `wide`, where there are any.

    An integer input that is fed by whole numbers with whole weights is their exact sum.
    """
    values = seen.astype(float) if seen.dtype == object else seen
    found = given + weights @ values
    if not wide:
        return found
    exact = found.astype(object)
    for i in wide:
        places = np.flatnonzero(weights[i]).tolist()
        factors = [float(weights[i, j]) for j in places]
        terms = [given[i], *factors, *(seen[j] for j in places)]
        if all(_is_whole(term) for term in terms):
            parts = zip(factors, places, strict=True)
            exact[i] = int(given[i]) + sum(int(w) * int(seen[j]) for w, j in parts)
    return exact


def _is_whole(number: Any) -> bool:
    return isinstance(number, int) or float(number).is_integer()
