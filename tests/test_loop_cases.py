"""Loops against values of two independent methods; their source is in tests/data/README.md."""

import json
from pathlib import Path

import numpy as np
import pytest
from loop_cases import run_case

CASES = json.loads((Path(__file__).parent / "data" / "loops.json").read_text(encoding="utf-8"))
RELATIVE = 1e-10


def leaves(expected, found, path=""):
    """Yield each expected value with its error estimate and what was found."""
    if not isinstance(expected, dict):
        yield path, expected, 0.0, found
    elif "value" in expected:
        estimate = expected.get("error_estimate", expected.get("error_estimate_s"))
        yield path, expected["value"], estimate, found
    else:
        for name, part in expected.items():
            if name != "error_estimate":
                yield from leaves(part, found[name], f"{path}/{name}")


@pytest.mark.parametrize("case", CASES["cases"], ids=[case["name"] for case in CASES["cases"]])
def test_a_case_comes_out_as_two_independent_methods_have_it(case):
    found = run_case(case["parameters"])
    for path, value, estimate, got in leaves(case["expected"], found):
        value, got = np.array(value, dtype=float), np.array(got, dtype=float)
        assert got.shape == value.shape, path
        scale = np.abs(value).max(initial=1e-3 if "residual" in path else 0.0)
        tolerance = max(10.0 * estimate, RELATIVE * scale)
        np.testing.assert_allclose(got, value, rtol=0, atol=tolerance, err_msg=path)


@pytest.mark.parametrize("case", CASES["cases"], ids=[case["name"] for case in CASES["cases"]])
def test_a_parameter_that_means_nothing_is_refused_wherever_it_stands(case):
    p = case["parameters"]
    parts = [name for name, value in p.items() if isinstance(value, dict)]
    for place in (None, *parts):
        inner = p if place is None else p[place]
        more = {**inner, "backlash": 1.0}
        more = more if place is None else {**p, place: more}
        with pytest.raises(ValueError, match="backlash: unknown"):
            run_case(more)
