"""A proven bound is never above a feasible duration: both in 50 digits, on random problems."""

import os
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from exact_plans import DIGITS, feasible_duration, is_proven
from whole_problems import random_problem

from jounce.shaping import InfeasibleError, Limits, certify, min_time_move, perfect_spline

MANY = range(20, 60 if os.environ.get("JOUNCE_TIER") == "slow" else 20)
WHOLE = [(0, 4), (7, 4), (4, 5), *((seed, order) for order in (4, 5) for seed in MANY)]
HALF = [(0, 4), (1, 5), *((seed, order) for order in (3, 4, 5, 6) for seed in MANY)]


def assert_never_above(move, start, end, limits, path, rtol=1e-4):
    certificate = certify(move, limits, rtol=rtol)
    feasible = feasible_duration(move, start, end, limits)
    with mpmath.workdps(DIGITS):
        assert mpmath.mpf(certificate.lower_bound) <= feasible
    certificate.save(path)
    assert is_proven(path)
    return certificate


@pytest.mark.parametrize("moving", [True, False])
@pytest.mark.parametrize(("seed", "order"), WHOLE)
def test_over_the_whole_horizon(seed, order, moving, tmp_path):
    problem = random_problem(seed, order, moving=moving)
    try:
        move = problem.solve()
    except InfeasibleError:
        pytest.skip("no motion, proven")
    path = tmp_path / "proof.json"
    assert_never_above(move, problem.start, problem.end, problem.limits, path)


@pytest.mark.parametrize(("seed", "order"), HALF)
def test_over_half_the_horizon(seed, order, tmp_path):
    """Even bounds alike, sometimes a long cruise; proven from a slow motion as well."""
    rng = np.random.default_rng((seed, order))
    peaks = [perfect_spline(1.0, order, 4.0 ** (order - 1)).peak(k) for k in range(1, order + 1)]
    bounds = [p * 10.0 ** rng.uniform(-0.8, 0.3) for p in peaks]
    if seed % 2:
        bounds[0] *= 0.05
    pairs = [(-b * (rng.uniform(0.5, 2.0) if k % 2 == 0 else 1.0), b) for k, b in enumerate(bounds)]
    limits, rest = Limits.from_bounds(pairs), [0.0] * (order - 1)
    move = min_time_move(1.0, limits)
    proof = assert_never_above(move, [0.0, *rest], [1.0, *rest], limits, tmp_path / "proof.json")
    slow = certify(min_time_move(1.0, limits, method="closed-form").stretch(1.2), limits)
    assert slow.check()
    assert slow.lower_bound <= move.duration * (1.0 + 1e-12)
    assert slow.lower_bound >= proof.lower_bound * (1.0 - 5e-3)


@pytest.mark.parametrize("order", [2, 4, 7, 10])
def test_where_the_minimum_is_known_to_50_digits(order, tmp_path):
    """Of perfect splines, to which the proof comes within 1e-12."""
    limits = Limits.from_bounds([*[None] * (order - 1), 3.0])
    certificate = certify(perfect_spline(2.0, order, 3.0), limits, rtol=1e-11)
    with mpmath.workdps(DIGITS):
        divisor = mpmath.factorial(order - 1) * mpmath.mpf(4) ** (order - 1)
        exact = (mpmath.mpf(2) / 3 * divisor) ** (mpmath.mpf(1) / order)
        assert exact * (1 - mpmath.mpf(10) ** -11) <= certificate.lower_bound <= exact
    certificate.save(tmp_path / "proof.json")
    assert is_proven(tmp_path / "proof.json")


@pytest.mark.parametrize("factor", [1.0 + 1e-4, 1.0 + 1e-9])
def test_what_tells_of_a_proof_sees_when_it_claims_too_much(factor, tmp_path):
    limits = Limits.from_bounds([0.5, 6.0, 60.0])
    certificate = certify(min_time_move(1.0, limits), limits)
    [link] = certificate.proof.links
    longer = replace(link, high=factor * link.high)
    claimed = replace(certificate.proof, links=(longer,), lower_bound=longer.high)
    replace(certificate, proof=claimed).save(tmp_path / "proof.json")
    assert not is_proven(tmp_path / "proof.json")
