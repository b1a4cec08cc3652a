"""Responses by substitution against factors multiplied out; grids kept between controllers."""

import control
import numpy as np
import pytest
from measured_loops import random_loop

from jounce.analysis import MeasuredResponse, loop_margins
from jounce.analysis.measured.state_groups import state_groups
from jounce.plant import PID, Controller


@pytest.mark.parametrize("seed", range(6))
def test_a_chain_of_first_and_second_orders_is_the_product_of_its_factors(seed):
    rng = np.random.default_rng(seed)
    system, exact = control.ss([], [], [], [[2.0]]), 2.0
    s = 2j * np.pi * np.geomspace(1e-3, 1e5, 300)
    for _ in range(rng.integers(0, 5)):
        size, damping = 10 ** rng.uniform(0, 4), 10 ** rng.uniform(-3, 0)
        part = control.ss([[0, size], [-size, -2 * damping * size]], [[0], [size]], [[1, 0]], 0)
        system = control.series(system, part, control.ss([[-size]], [[size]], [[-1]], [[1]]))
        exact = exact * size**2 / (s**2 + 2 * damping * size * s + size**2) * s / (s + size)
    found = state_groups(system).at(s)
    assert np.abs(found / exact - 1.0).max() < 1e-8


def test_a_gain_has_no_states():
    gain = state_groups(control.ss([], [], [], [[3.0]])).at(np.array([1j, 2j]))
    assert gain.tolist() == [3.0, 3.0]


def test_margins_do_not_hang_on_the_controllers_that_were_looked_at_before():
    rng = np.random.default_rng(4)
    plant, controller, crossover = random_loop(rng)
    lines = crossover / 12.0 * np.arange(1.0, 140.0)
    values = plant(np.exp(2j * np.pi * lines * controller.sample_time))
    given = {"kind": "plant", "dt": controller.sample_time}
    used = MeasuredResponse(lines, values, 0.01 * abs(values), **given)
    other = Controller(PID(1.0, 2.0, 0.1, derivative_filter=1e-3), sample_time=used.dt)
    loop_margins(used, controller=other)
    fresh = MeasuredResponse(lines, values, 0.01 * abs(values), **given)
    found = [loop_margins(each, controller=controller).as_dict() for each in (used, fresh)]
    assert found[0] == found[1]
