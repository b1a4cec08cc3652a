"""Named tuples of arrays: rows taken, chosen, mirrored and put back."""

import numpy as np
import pytest
from batches import stacked, unstacked
from strategies import random_transfer

from jounce.shaping.transfers import batch_tasks, brake
from jounce.shaping.transfers.batch_tasks import choose, mirror_where, put, take

COUNT = 8
TASKS = [random_transfer(np.random.default_rng(seed)).task for seed in range(COUNT)]
OTHERS = [task.in_units(2.0, 3.0) for task in TASKS]
EVEN = np.arange(COUNT) % 2 == 0


@pytest.fixture(autouse=True)
def _arguments_stay_as_they_are():
    yield
    assert unstacked(MANY) == TASKS
    assert unstacked(MORE) == OTHERS


MANY, MORE = stacked(TASKS), stacked(OTHERS)


@pytest.mark.parametrize(
    "which", [slice(2, 5), [7, 0, 0], EVEN, slice(0, 0), np.array([], dtype=int)], ids=str
)
def test_take_returns_some_rows(which):
    expected = [TASKS[i] for i in np.arange(COUNT)[which]]
    taken = take(MANY, which)
    assert type(taken) is type(MANY)
    assert unstacked(taken) == expected


@pytest.mark.parametrize("where", [EVEN, ~EVEN, EVEN | True, EVEN & False], ids=str)
def test_choose_returns_one_or_the_other(where):
    expected = [a if chosen else b for chosen, a, b in zip(where, TASKS, OTHERS, strict=True)]
    assert unstacked(choose(where, MANY, MORE)) == expected


@pytest.mark.parametrize("where", [EVEN, ~EVEN, EVEN | True, EVEN & False], ids=str)
def test_mirror_where_is_the_mirror_of_each(where):
    expected = [task.mirror() if mirrored else task
                for mirrored, task in zip(where, TASKS, strict=True)]  # fmt: skip
    assert unstacked(mirror_where(where, MANY)) == expected
    assert unstacked(mirror_where(where, mirror_where(where, MANY))) == TASKS


@pytest.mark.parametrize("which", [[1, 4, 6], [6, 1], [], EVEN], ids=str)
def test_put_replaces_some_rows(which):
    which = np.array(which, dtype=EVEN.dtype if which is EVEN else int)
    rows = np.arange(COUNT)[which]
    replaced = put(MANY, which, take(MORE, which))
    expected = [OTHERS[i] if i in rows else TASKS[i] for i in range(COUNT)]
    assert unstacked(replaced) == expected
    assert unstacked(put(replaced, which, take(MANY, which))) == TASKS
    assert not any(np.shares_memory(a, b) for a, b in zip(replaced, MANY, strict=True))


def test_inside_is_that_of_each():
    low, high = -2.0, 3.0
    values = np.array([x * (1.0 + k * 2.0**-52) for x in (low, 0.0, high) for k in (-9, 0, 9, 99)])
    expected = [brake.inside(value, low, high) for value in values.tolist()]
    assert batch_tasks.inside(values, low, high).tolist() == expected
    assert batch_tasks.inside(values, -np.inf, np.inf).tolist() == values.tolist()
