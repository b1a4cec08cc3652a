"""Margins where gain or phase touches, at frequency 0 and at infinity, and of unstable loops."""

import math

import control
import numpy as np
import pytest
from one_loops import S, delayed_pid, evaluate, flexible_loop

from jounce.analysis.margins import loop_margins

BETA = 3 + 2 * math.sqrt(2)


@pytest.mark.parametrize("zeta", [0.5, 0.01, 0.001])
def test_a_resonance_that_touches_unit_gain_has_one_crossover_there(zeta):
    touching = 2 * zeta * math.sqrt(1 - zeta**2)

    def crossovers(factor):
        return loop_margins(control.tf([factor * touching], [1, 2 * zeta, 1])).crossovers_hz

    assert crossovers(1) == pytest.approx((math.sqrt(1 - 2 * zeta**2) / (2 * np.pi),), rel=1e-12)
    assert len(crossovers(1 + 1e-8)) == 2
    assert crossovers(1 - 1e-8) == ()


def test_a_phase_that_touches_180_degrees_is_a_phase_crossover():
    loop = (S + 1) ** 2 / (S**3 * (S / BETA + 1) ** 2)
    assert loop_margins(loop).phase_crossovers_hz == pytest.approx(
        ((1 + math.sqrt(2)) / (2 * np.pi),), rel=1e-6
    )


def test_phase_and_delay_margins_are_taken_at_their_own_crossovers():
    margins = loop_margins(flexible_loop())
    assert margins.delay_margin_hz == max(margins.crossovers_hz)
    assert margins.crossover_hz == min(margins.crossovers_hz)


def test_phase_margin_towards_lead_counts():
    """A resonance turned by +60° crosses unit gain first in the second quadrant."""
    corner = 1 / math.tan(math.radians(75))
    loop = 0.3 * S / (S**2 + 0.1 * S + 1) * ((1 - S / corner) / (1 + S / corner)) ** 2
    margins = loop_margins(loop)
    assert margins.stable
    value = evaluate(loop, 2 * np.pi * margins.crossover_hz)
    assert 90 < np.angle(value, deg=True) < 180
    assert margins.phase_margin_deg == pytest.approx(180 - np.angle(value, deg=True), rel=1e-9)
    assert margins.crossover_hz == margins.crossovers_hz[0]
    assert margins.delay_margin_hz == margins.crossovers_hz[1]


@pytest.mark.parametrize(
    ("loop", "real_part"),
    [
        (50 / (S + 1) ** 3, 50 ** (1 / 3) / 2 - 1),
        (1 / S**2, 0.0),
        (control.tf([1, 0], [1, 1, 0]), 0.0),
        (control.tf([1, -1], [1, 1, -2]), 1.0),
        (control.ss([[-1, 0], [0, 2]], [[1], [0]], [[1, 1]], 0), 2.0),
        (-2 / (S + 1), 1.0),
    ],
    ids=["gain", "undamped", "hidden-integrator", "hidden-rhp", "uncontrollable", "sign"],
)
def test_an_unstable_loop_has_no_margins_and_names_its_worst_pole(loop, real_part):
    margins = loop_margins(loop)
    assert not margins.stable
    numbers = margins.as_dict()
    named = {"stable", "closed_loop_poles", "crossovers_hz", "phase_crossovers_hz"}
    named |= {"stabilizing_gains", "stabilizing_delays_s"}
    assert {name for name, value in numbers.items() if value is not None} == named
    assert math.isnan(margins.phase_margin_deg)
    assert margins.closed_loop_poles[0].real == pytest.approx(real_part, abs=1e-12)
    assert margins.summary().startswith("UNSTABLE: closed-loop pole at")
    assert f"{complex(margins.closed_loop_poles[0]) + 0.0:.4g}" in str(margins)


def test_an_unstable_loop_still_lists_its_crossovers():
    crossover = math.sqrt(50 ** (2 / 3) - 1) / (2 * np.pi)
    assert loop_margins(50 / (S + 1) ** 3).crossovers_hz == pytest.approx((crossover,), rel=1e-9)


def test_undamped_modes_and_integrators_do_not_count_as_phase_crossovers():
    margins = loop_margins((S**2 + 0.5) / (S * (S**2 + 1)))
    assert margins.stable
    assert margins.phase_crossovers_hz == ()
    assert margins.lower_gain_margin_db == math.inf


def test_zero_loop_gain_leaves_every_margin_unlimited():
    margins = loop_margins(control.tf([0], [1, 1]))
    assert margins.stable
    assert margins.crossovers_hz == margins.phase_crossovers_hz == ()
    limits = ("phase_margin_deg", "lower_gain_margin_db", "upper_gain_margin_db", "delay_margin_s")
    assert all(getattr(margins, name) == math.inf for name in limits)
    assert (margins.modulus_margin, margins.disk_margin, margins.complementary_peak) == (1, 2, 0)
    assert math.isnan(margins.crossover_hz)
    assert math.isnan(margins.bandwidth_hz)


def test_unobservable_input_is_zero_loop_gain():
    hidden = control.ss([[-1, 0], [0, -2]], [[1], [0]], [[0, 1]], 0)
    assert loop_margins(hidden).crossovers_hz == ()
    assert loop_margins(hidden).modulus_margin == 1


@pytest.mark.parametrize(
    ("gain", "lower", "upper", "hz"),
    [(-2.0, 20 * math.log10(2), math.inf, 0), (-0.5, math.inf, 20 * math.log10(2), 0)],
)
def test_gain_margins_count_the_limit_at_dc(gain, lower, upper, hz):
    loop = control.tf([gain], [math.copysign(1, gain + 1), 1])
    margins = loop_margins(loop)
    assert margins.lower_gain_margin_db == pytest.approx(lower, rel=1e-12)
    assert margins.upper_gain_margin_db == pytest.approx(upper, rel=1e-12)
    assert hz in (margins.lower_gain_margin_hz, margins.upper_gain_margin_hz)


def test_gain_margins_count_the_limit_at_infinite_frequency():
    margins = loop_margins((1 - S / 2) / (1 + S))
    assert margins.upper_gain_margin_db == pytest.approx(20 * math.log10(2), rel=1e-12)
    assert margins.upper_gain_margin_hz == math.inf


@pytest.mark.parametrize("loop", [(2 * S + 1) / (S + 1), S + 1, control.ss([], [], [], 1.0)])
def test_no_delay_is_tolerated_where_the_gain_does_not_roll_off(loop):
    margins = loop_margins(loop)
    assert margins.stable
    assert (margins.delay_margin_s, margins.delay_margin_hz) == (0, math.inf)


def test_unit_gain_at_dc_is_a_crossover_at_zero():
    margins = loop_margins(1 / (S + 1))
    assert margins.crossovers_hz == (0,)
    assert margins.phase_margin_deg == 180
    assert margins.delay_margin_s == math.inf
    assert margins.bandwidth_hz == pytest.approx(1 / np.pi, rel=1e-12)


@pytest.mark.parametrize("corner", [3e-6, 7, 1e3, 2.0**20, 3e7])
@pytest.mark.parametrize("form", [control.tf, lambda n, d: control.ss(control.tf(n, d))])
def test_unit_gain_at_dc_is_no_crossover_beside_it(form, corner):
    margins = loop_margins(form([corner], [1, corner]))
    assert (margins.crossovers_hz, margins.delay_margin_s) == ((0,), math.inf)
    assert margins.stabilizing_delays_s == ((0, math.inf),)
    two = loop_margins(form([corner**2], [1, corner, corner**2]))  # |L| = 1 at 0 and at the corner
    assert two.crossovers_hz == pytest.approx((0, corner / (2 * np.pi)), rel=1e-12)
    assert two.delay_margin_s == pytest.approx(np.pi / 2 / corner, rel=1e-12)


def test_bandwidth_is_where_t_first_falls_by_three_decibels():
    loop = delayed_pid()
    margins = loop_margins(loop)
    omega = 2 * np.pi * margins.bandwidth_hz * np.array([1e-6, 0.2, 0.5, 0.8, 0.999999, 1])
    size = abs(evaluate(loop, omega) / (1 + evaluate(loop, omega)))
    assert size[-1] == pytest.approx(1 / math.sqrt(2), rel=1e-10)
    assert np.all(size[:-1] > 1 / math.sqrt(2))
    assert math.isnan(loop_margins(S / (S + 1)).bandwidth_hz)
    assert math.isnan(loop_margins((S + 1) / (S + 2)).bandwidth_hz)
