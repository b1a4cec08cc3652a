"""S, T, PS and CS of a continuous loop with two encoders, from the equations of its parts."""

import numpy as np
import pytest
from tiers import some

from jounce.analysis import survey
from jounce.plant import PID, Axis, CascadedPI, Controller, FlexibleMode, LowPass, ServoLoop

AXIS = Axis(
    2.0,
    modes=[FlexibleMode(20.0, 0.01, load_fraction=0.4)],
    viscous=0.5,
    current_lag=5e-4,
    sensor="both",
)
S = 2j * np.pi * np.array([0.3, 2.0, 9.0, 19.0, 60.0])
LAWS = {
    "cascade": Controller(CascadedPI(20.0, 60.0, 0.2), filters=[LowPass(200.0)]),
    "PID": Controller(PID(1500.0, 3000.0, 70.0, derivative_filter=1e-3)),
}


def parts(name):
    """Return what a torque makes of both positions, and what u makes of y_load and v_motor."""
    load = (1 - 0.4) / 0.4
    w, z = 2 * np.pi * 20.0, 0.01
    # In modes q0, q1: (J + B a aᵀ) with a = (1, √(λ/(1−λ))), b = (1, −√((1−λ)/λ)).
    a = np.array([1.0, np.sqrt(0.4 / 0.6)])
    b = np.array([1.0, -np.sqrt(load)])
    g = []
    for s in S:
        matrix = 2.0 * np.diag([s * s, s * s + 2 * z * w * s + w * w]) + 0.5 * s * np.outer(a, a)
        q = np.linalg.solve(matrix, a)
        g.append([a @ q, b @ q])
    motor, seen = np.array(g).T / (1 + 5e-4 * S)
    if name == "PID":
        return motor, seen, 1500.0 + 3000.0 / S, 70.0 / (1 + 1e-3 * S)
    low = (400 * np.pi) ** 2 / (S * S + 2 * 0.7 * 400 * np.pi * S + (400 * np.pi) ** 2)
    speed = 60.0 * (1 + 1 / (0.2 * S)) * low
    return motor, seen, 20.0 * speed, speed


@pytest.mark.parametrize("name", LAWS)
def test_the_four_are_those_of_both_signals(name):
    motor, seen, of_position, of_rate = parts(name)
    found = ServoLoop(AXIS, LAWS[name]).sensitivity()
    loop = of_position * seen + of_rate * S * motor
    expected = {
        "S": 1 / (1 + loop),
        "T": loop / (1 + loop),
        "PS": seen / (1 + loop),
        "CS": of_position / (1 + loop),
    }
    for each, values in expected.items():
        np.testing.assert_allclose(getattr(found, each)(S), values, rtol=1e-8, err_msg=each)


@pytest.mark.parametrize("name", some(LAWS, 1))
def test_a_survey_has_their_peaks(name):
    loop = ServoLoop(AXIS, LAWS[name])
    found = survey(loop, [])
    hz = np.geomspace(0.01, 500.0, 20_000)
    for peak, system in (
        (found.compliance, loop.sensitivity().PS),
        (found.noise_gain, loop.sensitivity().CS),
    ):
        assert peak.value == pytest.approx(abs(system(2j * np.pi * hz)).max(), rel=1e-4)
