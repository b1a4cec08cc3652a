"""Parameters of the cases varied to their edges, against scipy's solve_ivp."""

import copy
import json
from pathlib import Path

import numpy as np
import pytest
from loop_cases import run_case
from slow_loops import run_slowly
from tiers import some

DATA = json.loads((Path(__file__).parent / "data" / "loops.json").read_text(encoding="utf-8"))
CASES = {case["name"].replace("_shared", ""): case["parameters"] for case in DATA["cases"]}
CHAIN = {
    "type": "chain",
    "masses": [1.0, 0.5, 0.3],
    "springs": [4000.0, 6000.0],
    "dampers": [0.3, 0.5],
    "load_viscous_nm_s_per_rad": 0.2,
}
DRY = {"coulomb_nm": 1.0, "static_nm": 1.5}
SOFT = {"kp_nm_per_rad": 700.0, "kd_nm_s_per_rad": 40.0, "ki_nm_per_rad_s": 2000.0}
ALL_FILTERS = [
    {"kind": "notch", "zero_hz": 30.0, "pole_hz": 34.0, "zero_damping": 0.0, "pole_damping": 0.5},
    {"kind": "lowpass1", "corner_hz": 300.0},
    {"kind": "leadlag", "zero_hz": 60.0, "pole_hz": 90.0},
    {"kind": "lowpass2", "corner_hz": 150.0, "damping_ratio": 0.7},
]
CONDITIONAL = {"torque_limit_nm": 10.0, "anti_windup": "conditional"}
BACK = {"torque_limit_nm": 10.0, "anti_windup": "back_calculation", "tracking_time_s": 0.05}
CLAMP = {"torque_limit_nm": 10.0, "anti_windup": "clamp", "integrator_limit_nm": 0.2}
VARIANTS = {
    "chain": ("linear_one_mode", 0.2, {"plant": CHAIN}, {}),
    "dry, continuous": ("linear_one_mode", 0.2, {"friction": DRY, "current_lag_s": 1e-3}, {}),
    "limit, continuous": ("linear_one_mode", 0.2, {}, CONDITIONAL),
    "several samples late": ("fractional_delay", 0.15, {}, {"computing_delay_s": 2.35e-3} | SOFT),
    "filters": ("notch_and_lowpass", 0.15, {"friction": DRY}, {"filters": ALL_FILTERS} | SOFT),
    "cascade at its limit": ("p_pi_cascade", 0.1, {"friction": DRY}, BACK),
    "cascade clamped": ("p_pi_cascade", 0.1, {}, {"encoder_step_rad": 1e-5} | CLAMP),
    "never at the limit": ("torque_limit_anti_windup_none", 0.1, {}, {"torque_limit_nm": 500.0}),
    "always at it": ("torque_limit_anti_windup_none", 0.1, {}, {"torque_limit_nm": 0.5}),
    "limit and dry": ("torque_limit_anti_windup_conditional", 0.15, {"friction": DRY}, CONDITIONAL),
    "friction fed": ("coulomb_reversal", 0.4, {}, {"friction_feedforward_nm": 2.5}),
    "hunting, coarse": ("quantiser_hunting", 0.3, {}, {"encoder_step_rad": 1e-4}),
}


def varied(name):
    """Return the parameters of a variant."""
    base, duration, outside, inside = VARIANTS[name]
    p = copy.deepcopy(CASES[base]) | outside
    p["controller"] |= inside
    times = np.linspace(0.0137317 * duration, 0.98731713 * duration, 9)
    return p | {"duration_s": duration, "instants_s": times.tolist()}


@pytest.mark.parametrize("name", some(VARIANTS, 4))
def test_a_variant_comes_out_as_solve_ivp_has_it(name):
    p = varied(name)
    found, expected = run_case(p), run_slowly(p)
    for quantity, values in expected.items():
        wanted, got = np.array(values, dtype=float), np.array(found[quantity], dtype=float)
        assert got.shape == wanted.shape, quantity
        relative = 1e-7 if "peak" in quantity else 1e-9
        scale = np.abs(wanted).max(initial=0.0)
        np.testing.assert_allclose(got, wanted, rtol=0, atol=relative * scale, err_msg=quantity)
