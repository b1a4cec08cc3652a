"""Shapers as python-control systems: names, formulas, errors."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import gammainc

from jounce.plant import filter_system
from jounce.shaping import JerkFilter


@given(
    order=st.integers(1, 12),
    corner=st.sampled_from([1e-3, 0.7, 2.0, 5e4]),
    ratio=st.floats(-1.5, 1.0).map(lambda x: 10.0**x),
    data=st.data(),
)
def test_output_k_is_s_to_the_k_times_the_lags(order, corner, ratio, data):
    count = data.draw(st.integers(0, order - 1))
    s = 2j * np.pi * corner * ratio
    values = filter_system(JerkFilter(corner, order), derivatives=count)(s, squeeze=False)[:, 0]
    scaled = np.ravel(values) / (2 * np.pi * corner) ** np.arange(count + 1.0)
    expected = (1j * ratio) ** np.arange(count + 1.0) / (1 + 1j * ratio) ** order
    np.testing.assert_allclose(
        scaled, expected, rtol=0, atol=1e-13 * 4.0**count,
        err_msg=f"filter_system(JerkFilter({corner}, {order}), derivatives={count})({s})",
    )  # fmt: skip


def test_signals_have_the_shapers_names():
    system = filter_system(JerkFilter(2.0, 4), derivatives=3)
    assert isinstance(system, control.StateSpace)
    assert system.name == "jerk_filter"
    assert system.input_labels == ["r"]
    assert system.output_labels == ["y", "y_1", "y_2", "y_3"]
    assert system.state_labels == ["lag_1", "lag_2", "lag_3", "lag_4"]
    assert filter_system(JerkFilter(2.0, 1)).output_labels == ["y"]


@pytest.mark.parametrize("order", [1, 2, 6])
def test_its_step_response_is_the_gamma_distribution(order):
    t = np.linspace(0.0, 3.0, 301)
    response = control.forced_response(filter_system(JerkFilter(2.0, order)), t, np.ones(301))
    np.testing.assert_allclose(response.outputs, gammainc(order, 4 * np.pi * t), atol=1e-12)


@pytest.mark.parametrize("count", [-1, 4, 7])
def test_derivatives_that_need_the_command_itself_are_refused(count):
    with pytest.raises(
        ValueError, match=f"derivatives = {count}: expected a whole number from 0 to 3"
    ):
        filter_system(JerkFilter(2.0, 4), derivatives=count)
