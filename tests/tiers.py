"""The two tiers of tests: the fast one takes some cases of a test, the slow one takes them all."""

import os

SLOW = os.environ.get("JOUNCE_TIER") == "slow"


def some(cases, count: int) -> list:
    """Return all cases in the slow tier, else `count` of them, evenly from first to last."""
    cases = list(cases)
    if SLOW or len(cases) <= count:
        return cases
    return [cases[round(i * (len(cases) - 1) / max(count - 1, 1))] for i in range(count)]
