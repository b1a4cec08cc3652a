"""Surveys of loops as they are: flexible, digital, delayed, sticking and saturating."""

from dataclasses import replace
from itertools import pairwise
from math import inf, isnan, nan, pi, sqrt

import control
import numpy as np
import pytest
from real_loops import (
    ARCSEC,
    AXIS,
    BOUNDS,
    DEGREE,
    GAINS,
    LABELS,
    MAS,
    REAL,
    SMOOTH,
    J,
    mode,
    move,
    real_survey,
)
from scipy.integrate import solve_ivp

from jounce.analysis import (
    Mode,
    Requirement,
    Tracking,
    UnstableLoopError,
    loop_margins,
    residual_vibration,
    survey,
)
from jounce.analysis.limit_cycles import (
    LimitCycles,
    Standstill,
    quantiser_gain,
    shown_cycles,
    shown_wait,
)
from jounce.plant import (
    PID,
    Axis,
    CascadedPI,
    Clamp,
    Controller,
    Friction,
    Inertia,
    InertiaFeedforward,
    Ramp,
    Ripple,
    ServoLoop,
    Sine,
    TorqueSteps,
    Wind,
    design_pid,
    inverse_feedforward,
)
from jounce.shaping import JerkFilter, Limits, input_shaper, min_time_move


def integrated(command, duration):
    """Return dense outputs of two masses under the PID with Ĵ = J, integrated piece by piece."""
    omega = 2.0 * pi * 6.0
    load = motor = 0.5 * J
    k, c = load * omega**2, 2.0 * 0.01 * omega * load

    def rates(t, x):
        r, v, a = command.evaluate(np.array([t]), 2)[:, 0]
        motor_at, load_at, motor_v, load_v, integral = x
        u = GAINS.kp * (r - motor_at) + GAINS.ki * integral + GAINS.kr * (v - motor_v) + J * a
        spring = k * (load_at - motor_at) + c * (load_v - motor_v)
        return [motor_v, load_v, (u + spring) / motor, -spring / load, r - motor_at]

    breaks, x, parts = [*command.breaks, duration], np.zeros(5), []
    for begin, end in pairwise(breaks):
        inside = (begin, np.nextafter(end, begin))
        times = np.linspace(begin, end, 4000)
        ends = [*times[:-1], inside[1]]
        found = solve_ivp(rates, inside, x, "DOP853", ends, rtol=1e-11, atol=1e-16)
        parts.append((times[:-1], found.y[1, :-1]))
        x = found.y[:, -1]
    return np.concatenate([t for t, _ in parts]), np.concatenate([y for _, y in parts])


def test_the_load_of_the_telescope_needs_4_4_seconds_fed_as_a_rigid_axis():
    found = survey(ServoLoop(AXIS, GAINS, InertiaFeedforward(J)), [move()])
    result = found.moves[0].configured
    assert found.moves[0].duration_s == pytest.approx(1.4315, abs=1e-4)
    assert result.load_settling_time_s == pytest.approx(4.4, abs=0.05)
    times, load = integrated(found.moves[0].trajectory, 9.0)
    outside = np.abs(load - 3.5 * DEGREE) > 50.0 * MAS
    last = int(np.flatnonzero(outside)[-1])
    assert times[last] <= result.load_settling_time_s <= times[last + 1]
    error = found.moves[0].trajectory(times) - load
    assert result.peak_load_error == pytest.approx(np.abs(error).max(), rel=1e-5)
    after = np.abs(error[times >= found.moves[0].duration_s]).max()
    assert result.left_over == pytest.approx(after, rel=1e-5)
    assert result.left_over > 100.0 * 50.0 * MAS


def test_it_needs_1_495_seconds_with_snap_bounded_and_the_exact_inverse():
    exact = inverse_feedforward(Axis(J, modes=[mode(damping=0.0)]))
    found = survey(ServoLoop(AXIS, GAINS, exact), [SMOOTH])
    result = found.moves[0].configured
    assert result.load_settling_time_s == pytest.approx(1.495, abs=5e-4)
    assert result.left_over < 50.0 * MAS
    undamped = survey(ServoLoop(Axis(J, modes=[mode(0.0)]), GAINS, exact), [SMOOTH])
    assert undamped.moves[0].configured.peak_load_error < 1e-9 * 3.5 * DEGREE


def test_a_rigid_survey_says_that_its_modes_take_no_part():
    rigid = ServoLoop(Inertia(J), GAINS, InertiaFeedforward(J))
    found = survey(rigid, [move()], modes=[Mode("tower", 6.0, 0.01)], labels=LABELS)
    first, second = found.notes
    assert "rigid" in first
    assert "open loop" in first
    left = found.moves[0].residual_vibration["tower"]
    assert f"{left / ARCSEC:.3g} arcsec" in second
    assert f"{left / (50.0 * MAS):.3g} times the tolerance" in second
    quiet = replace(move(), shapers=(input_shaper("ZV", 6.0, 0.01),))
    assert len(survey(rigid, [quiet], modes=[Mode("tower", 6.0, 0.01)]).notes) == 1


def test_shapers_make_the_command_longer_and_null_the_mode():
    zv, other = input_shaper("ZV", 6.0, 0.01), input_shaper("ZVD", 20.0)
    loop = ServoLoop(Inertia(J), GAINS, InertiaFeedforward(J))
    plain = min_time_move(3.5 * DEGREE, Limits.from_bounds(BOUNDS))
    shaped = replace(move(), shapers=(zv, other))
    found = survey(loop, [shaped], modes=[Mode("tower", 6.0, 0.01)])
    [one] = found.moves
    assert one.duration_s == pytest.approx(plain.duration + zv.duration + other.duration)
    assert one.residual_vibration["tower"] < 1e-12 * residual_vibration(plain, 6.0, 0.01)
    assert replace(move(), shapers=zv).shapers == (zv,)
    with pytest.raises(TypeError, match=r"^shapers = 'ZV': expected input_shaper"):
        replace(move(), shapers=("ZV",))


def test_margins_have_delay_and_sampling_as_they_are():
    margins = real_survey().margins
    assert margins.dt == 1e-3
    assert margins.as_dict() == loop_margins(REAL).as_dict()
    later = ServoLoop(REAL.plant, replace(REAL.controller, delay=4e-3), REAL.feedforward)
    assert loop_margins(later).phase_margin_deg == pytest.approx(
        margins.phase_margin_deg - 360.0 * 2.5e-3 * margins.crossover_hz, abs=0.05
    )


def test_peaks_of_all_four_are_those_of_dense_frequencies():
    found, curves = real_survey(), REAL.sensitivity()
    frequency = np.unique(
        np.concatenate([np.geomspace(1e-2, 500.0, 4000), np.linspace(8.3, 8.7, 2000)])
    )
    points = np.exp(2j * pi * frequency * 1e-3)
    for system, peak in (
        (curves.S, found.margins.sensitivity_peak),
        (curves.T, found.margins.complementary_peak),
        (curves.PS, found.compliance.value),
        (curves.CS, found.noise_gain.value),
    ):
        seen = np.abs(system(points)).max()
        assert seen <= peak * (1.0 + 1e-12)
        assert seen == pytest.approx(peak, rel=1e-4)


def test_the_unit_step_of_a_digital_loop_is_that_of_its_closed_loop():
    """Of a PID with one encoder y/r is T, between samples the position of a slow loop."""
    loop = ServoLoop(Axis(1.0, viscous=0.5), Controller(PID(40.0, 30.0, 12.0), sample_time=1e-3))
    found = survey(loop, []).step
    position = control.step_response(loop.sensitivity().T, 1e-3 * np.arange(9000)).outputs
    assert found.overshoot_percent == pytest.approx(100.0 * (position.max() - 1.0), abs=1e-3)
    assert found.peak_time_s == pytest.approx(1e-3 * position.argmax(), abs=1e-3)
    continuous = survey(ServoLoop(Axis(1.0, viscous=0.5), PID(40.0, 30.0, 12.0)), []).step
    polynomials = control.tf([12.0, 40.0, 30.0], [1.0, 12.5, 40.0, 30.0])
    exact = control.step_response(polynomials, np.linspace(0.0, 5.0, 50_001)).outputs.max()
    assert continuous.overshoot_percent == pytest.approx(100.0 * (exact - 1.0), abs=1e-4)


def test_an_ideal_derivative_amplifies_noise_without_end():
    found = survey(ServoLoop(Inertia(1.0), PID(1.0, 1.0, 2.0)), [])
    assert found.noise_gain.value == inf
    assert isnan(found.noise_gain.frequency_hz)
    assert found.moves == ()


def test_a_torque_step_is_that_of_the_linear_loop_where_nothing_limits():
    """Error = d·s/(J·s³ + kr·s² + kp·s + ki) of a rigid axis, summed over its poles."""
    loop = ServoLoop(Axis(J), GAINS)
    found = survey(loop, [], torque_step=5.0).disturbance
    poles = np.roots([J, GAINS.kr, GAINS.kp, GAINS.ki])
    times = np.linspace(0.0, 10.0, 400_001)
    load = np.zeros(len(times), dtype=complex)
    for i, pole in enumerate(poles):
        others = np.delete(poles, i)
        load += 5.0 / J / np.prod(pole - others) * np.exp(pole * times)
    assert found.peak == pytest.approx(np.abs(load.real).max(), rel=1e-8)
    last = times[np.flatnonzero(np.abs(load.real) > 0.1 * found.peak)[-1]]
    assert found.recovery_time_s == pytest.approx(last, abs=5e-5)
    steps = TorqueSteps([0.0, 1.0], [3.0, 2.0], on="motor")
    assert survey(loop, [], torque_step=steps).disturbance.torque == 5.0


def test_the_budget_has_each_source_and_deterministic_ones_apart():
    found = real_survey()
    by_name = {source.name: source for source in found.budget}
    assert [source.kind for source in found.budget] == ["random"] * 3 + ["deterministic"]
    noise = REAL.deviations(encoder_noise=5.0 * MAS)
    assert by_name["encoder noise"].load == noise.load
    coarse = by_name["quantisation"]
    assert coarse.load == pytest.approx(noise.load / sqrt(12.0), rel=1e-9)
    spike = by_name["friction at a reversal"].load
    assert spike == pytest.approx(1.01 * 4.0 / GAINS.kp, rel=0.25)


def test_a_limited_move_is_at_its_limit_and_the_survey_says_how_long():
    for one in real_survey().moves:
        result = one.configured
        assert result.peak_torque == 150.0
        assert 0.1 < result.saturated_time_s < one.duration_s
        assert result.peak_load_error > 10.0 * ARCSEC


def test_tracking_errors_are_those_of_fine_samples():
    loop = ServoLoop(AXIS, Controller(GAINS, sample_time=1e-3, delay=1e-3))
    tracked = Tracking("dither", Sine(10.0 * ARCSEC, 0.5), 8.0, after=2.0)
    [found] = survey(loop, [], tracking=[tracked]).tracking
    times = np.linspace(0.0, 8.0, 80_001)
    error = loop.respond(tracked.command, times=times).load_error[times >= 2.0]
    assert found.peak_error == pytest.approx(np.abs(error).max(), rel=1e-6)
    assert found.rms_error == pytest.approx(sqrt(np.trapezoid(error**2, dx=1e-4) / 6.0), rel=1e-6)
    assert found.slips == 0
    with pytest.raises(ValueError, match=r"^after = 8.0: expected a time from 0 to below"):
        replace(tracked, after=8.0)


@pytest.mark.parametrize("amplitude", [0.4, 0.55, 1.0 / sqrt(2.0), 1.3, 2.7])
def test_the_quantisers_describing_function_is_its_first_harmonic(amplitude):
    angle = (np.arange(400_000) + 0.5) * 2.0 * pi / 400_000
    rounded = np.floor(amplitude * np.sin(angle) + 0.5)
    harmonic = 2.0 * np.mean(rounded * np.sin(angle)) / amplitude
    assert quantiser_gain(amplitude, 1.0) == pytest.approx(harmonic, abs=2e-5)


def test_a_quantiser_is_foreseen_to_hunt_about_the_lower_margin():
    """PID on an inertia, the command between two counts: it swings less than a count."""
    step = 1e-4
    controller = Controller(
        design_pid(2.0, crossover_hz=4.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0),
        sample_time=1e-3,
    )
    loop = ServoLoop(Axis(2.0, encoder_step=step), controller)
    found = survey(loop, []).limit_cycles
    [cycle] = found.foreseen
    margins = loop_margins(loop)
    assert quantiser_gain(cycle.amplitude, step) == pytest.approx(
        10.0 ** (-margins.lower_gain_margin_db / 20.0)
    )
    assert 0.5 * step < cycle.amplitude < step / sqrt(2.0)
    assert cycle.frequency_hz == margins.lower_gain_margin_hz
    assert 0.01 * step < found.standstill.swing < 2.0 * step  # about the edge of a count
    assert isnan(found.standstill.next_breakaway_s)
    assert len(shown_cycles(found, "rad", 1.0)) == 2


@pytest.mark.parametrize("static", [3.6, 4.5])
def test_stiction_hunts_and_no_describing_function_foresees_it(static):
    """|e| = 0.56 (Fs − Fc)/kp on every stick, as published runs of 600 s show."""
    gains = design_pid(2.0, crossover_hz=4.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    axis = Axis(2.0, friction=Friction(3.0, static))
    found = survey(ServoLoop(axis, Controller(gains, sample_time=1e-3)), []).limit_cycles
    assert found.foreseen == ()
    assert found.standstill.slips > 0
    told = " ".join(shown_cycles(found, "rad", 1.0))
    assert "describing function foresees no cycle" in told
    assert "hunts" in told


def test_a_stuck_axis_is_not_at_rest():
    result = real_survey().moves[0].responses["with feedforward"]
    end = result.response.time[-1]
    assert result.next_breakaway_s == result.response.next_breakaway >= end
    rigid = survey(ServoLoop(AXIS, GAINS), [move()])
    assert isnan(rigid.moves[0].configured.next_breakaway_s)


def test_requirements_are_met_or_missed_by_how_much():
    found = real_survey()
    checks = {check.requirement.name: check for check in found.requirements}
    phase, settling, torque = (
        checks[name] for name in ("phase_margin", "load_settling", "slew.peak_torque")
    )
    assert phase.met
    assert phase.achieved == found.margins.phase_margin_deg
    assert not settling.met
    assert settling.achieved == max(m.configured.load_settling_time_s for m in found.moves)
    assert settling.missed_by == settling.achieved - 2.0
    assert torque.achieved == found.moves[0].configured.peak_torque == 150.0
    assert torque.met
    [line] = found.unmet
    assert line.startswith("Required load_settling ≤ 2 s is ")


@pytest.mark.parametrize(
    ("name", "bounds", "message"),
    [
        ("load_setling", {"most": 2.0}, "is of no figure: did you mean 'load_settling'"),
        ("load_settling", {}, "bounds nothing: give least=… or most=…"),
        ("load_settling", {"least": 3.0, "most": 2.0}, "nothing is at least 3.0 and at most 2.0"),
    ],
)
def test_requirements_of_nothing_are_refused(name, bounds, message):
    with pytest.raises(ValueError, match=f"^requirement '{name}'.*{message}"):
        Requirement(name, **bounds)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("there.load_settling", "there is no 'there'; there are 'slew'"),
        ("slew.phase_margin", "phase_margin is a figure of the whole loop; write 'phase_margin'"),
        ("rms_load", "has no such figure; give wind=…"),
        ("disturbance_peak", "has no such figure; give torque_step=…"),
        ("tracking_rms", "has no such figure; give tracking=…"),
    ],
)
def test_requirements_of_what_there_is_not_are_refused(name, message):
    loop = ServoLoop(Inertia(J), GAINS)
    with pytest.raises(ValueError, match=f"^requirement '{name}': .*{message}"):
        survey(loop, [move()], requirements=[Requirement(name, most=1.0)])


def test_a_missing_settling_is_missed_by_an_unknown_amount():
    asked = Requirement("load_settling", most=2.0)
    check = real_survey().requirements[2]
    assert replace(check, requirement=asked, achieved=inf).shown(LABELS) == (
        "≤ 2 s",
        "not reached",
        "missed",
    )


def test_an_unstable_digital_loop_names_its_pole_in_z():
    late = Controller(GAINS, sample_time=0.02, delay=0.2)
    with pytest.raises(UnstableLoopError, match=r"^the closed loop is UNSTABLE, .* at z = 1"):
        survey(ServoLoop(AXIS, late), [move()])


def test_a_filter_in_front_of_a_digital_loop_is_refused_in_one_line():
    with pytest.raises(ValueError, match=r"^move 'slew': a jerk filter in front of") as raised:
        survey(REAL, [move()], jerk_filter=JerkFilter(2.0, 3))
    assert "\n" not in str(raised.value)


def test_noise_of_a_continuous_loop_is_refused():
    with pytest.raises(ValueError, match=r"^encoder_noise = 1e-06 in a continuous loop"):
        survey(ServoLoop(AXIS, GAINS), [], encoder_noise=1e-6)
    wind = Wind("first_order", 1.0, corner_hz=1.0)
    assert len(survey(ServoLoop(AXIS, GAINS), [], wind=wind).budget) == 1


def test_a_resolution_that_no_sample_sees_is_told():
    axis = replace(AXIS, encoder_step=MAS)
    notes = survey(ServoLoop(axis, GAINS), []).notes
    assert any("does not see the encoder's resolution" in note for note in notes)


def test_a_tracking_command_that_cannot_be_followed_is_named():
    bad = Tracking("jump", min_time_move(1.0, Limits(1.0)), 3.0)
    with pytest.raises(ValueError, match=r"^tracking 'jump': "):
        survey(ServoLoop(AXIS, GAINS, InertiaFeedforward(J)), [], tracking=[bad])
    assert survey(REAL, [], tracking=[Tracking("still", Ramp(0.0), 1.0)]).tracking[0].slips == 0


IDEALISED = {
    "friction": {"friction": Friction(0.1, 0.12)},
    "ripple over position": {"ripple": Ripple.sine(0.1, 1.0)},
    "torque limit": {"torque_limit": 50.0},
    "resolution": {"encoder_step": 1e-5},
}


@pytest.mark.parametrize("names", [[name] for name in IDEALISED] + [list(IDEALISED)])
def test_what_the_linear_part_leaves_out_is_named_and_changes_nothing_in_it(names):
    gains = design_pid(2.0, crossover_hz=4.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
    controller = Controller(gains, sample_time=1e-3)
    given = {key: value for name in names for key, value in IDEALISED[name].items()}
    found = survey(ServoLoop(Axis(2.0, **given), controller), [])
    bare = survey(ServoLoop(Axis(2.0), controller), [])
    assert bare.notes == ()
    *others, last = names
    listed = f"{', '.join(others)} and {last}" if others else last
    assert f"are those of the linear part: without {listed}. Moves" in found.notes[0]
    assert found.step.overshoot_percent == bare.step.overshoot_percent
    assert found.margins.phase_margin_deg == bare.margins.phase_margin_deg


@pytest.mark.parametrize("integral", [0.0, 9500.0])
def test_constant_load_and_clamp_leave_the_step_of_the_linear_part_alone(integral):
    def step(load, clamp):
        law = PID(1263.0, integral, 65.0)
        controller = Controller(law, sample_time=1e-3, anti_windup=clamp)
        return survey(ServoLoop(Axis(2.0, constant_load=load), controller), []).step

    bare, loaded = step(0.0, None), step(40.0, Clamp(50.0))
    assert bare.overshoot_percent == loaded.overshoot_percent
    assert bare.settling_time_s == loaded.settling_time_s


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(0.5, "0.5000 s"), (7200.0, "2 h"), (1e9, "2.778e+05 h"), (1e10, "never"), (inf, "never")],
)
def test_waits_are_told_in_units_that_a_reader_grasps(seconds, told):
    assert shown_wait(seconds, "s") == told


def test_a_breakaway_in_an_hour_is_told_in_hours():
    still = Standstill(1e-3, 10.0, 0.0, 1e-6, 0, 7.2e5)
    [_, told] = shown_cycles(LimitCycles((), True, still), "rad", 1.0)
    assert "breaks away next at 200 h: stuck is not at rest" in told
    [_, told] = shown_cycles(LimitCycles((), True, replace(still, next_breakaway_s=5e9)), "rad", 1)
    assert "for good" in told


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"distance": 0.0}, "distance = 0.0: expected a distance other than 0"),
        ({"distance": nan}, "distance = nan: expected a finite number"),
        ({"settle_to": 0.0}, "settle_to = 0.0: expected a positive tolerance, smaller than"),
        ({"settle_to": 2.0}, "settle_to = 2.0: expected a positive tolerance, smaller than"),
    ],
)
def test_a_move_that_is_none_is_refused_where_it_is_built(given, told):
    with pytest.raises(ValueError, match=told):
        replace(move(), **given)


def test_a_bound_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="'load_settling': most = nan: expected a number"):
        Requirement("load_settling", most=nan)


def test_a_continuous_loop_that_sticks_for_hours_is_surveyed():
    axis = Axis(2.0, friction=Friction(1.0))
    found = survey(ServoLoop(axis, PID(1263.0, 9525.0, 65.0)), []).limit_cycles
    assert found.standstill.next_breakaway_s > 3600.0
    assert " h: stuck is not at rest" in shown_cycles(found, "rad", 1.0)[-1]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"moves": [3]}, r"moves = 3: expected Move\(…\)"),
        ({"moves": move()}, r"moves = Move\(.*: expected a list of Move\(…\)"),
        ({"requirements": ["phase_margin"]}, "requirements = 'phase_margin': expected Requirement"),
        ({"wind": 3.0}, r"wind = 3.0: expected Wind\(…\), Spectrum\(…\) or a list of them"),
        ({"labels": "arcsec"}, "labels = 'arcsec': expected Labels"),
        ({"loop": 3}, "loop = 3: expected a ServoLoop"),
    ],
)
def test_what_no_survey_takes_is_refused(given, told):
    with pytest.raises(TypeError, match=told):
        survey(**{"loop": REAL, "moves": [], **given})


def test_a_mode_too_slow_to_wait_for_is_told_in_one_line():
    def told(position_gain):
        law = CascadedPI(position_gain, 10.0, reset_time=1.0)
        loop = ServoLoop(Axis(1.0, torque_limit=50.0), Controller(law, sample_time=0.05))
        return [line for line in survey(loop, []).notes if line.startswith("The slowest mode")]

    [line] = told(1e-8)
    assert "takes 1e+08 s to fall to 37 %" in line
    assert "for 1e+04 s at most, 200,000 samples" in line
    assert told(1.0) == []


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_the_peak_of_the_current_behind_its_loop_is_told_where_its_constant_is_known(lag):
    controller = Controller(PID(28.0, 38.0, 6.6), sample_time=1e-3)
    for constant, told in ((0.5, True), (None, False)):
        axis = Axis(1.0, gear_ratio=10.0, torque_constant=constant, current_lag=lag)
        found = survey(ServoLoop(axis, controller, InertiaFeedforward(1.0)), [move()])
        shown = found.moves[0].configured
        assert ("motor current" in str(found)) == told
        assert isnan(shown.peak_current) != told
        if told:
            most = float(np.abs(shown.response.current).max())
            assert most <= shown.peak_current * (1.0 + 1e-12)
            assert shown.peak_current == pytest.approx(most, rel=1e-4)
            assert (shown.peak_current < 0.999 * shown.peak_torque / 5.0) == (lag > 0.0)


def test_a_torque_step_counts_from_where_a_constant_load_holds_the_axis():
    controller = Controller(PID(4e4, 8e4, 7e3), sample_time=1e-3)
    free, held = (
        survey(
            ServoLoop(Axis(J, modes=[mode()], constant_load=load), controller), [], torque_step=5.0
        )
        for load in (0.0, -40.0)
    )
    assert held.disturbance.response.load_error[0] > 1e-6
    assert held.disturbance.peak == pytest.approx(free.disturbance.peak, rel=1e-6)
    assert held.disturbance.final == pytest.approx(free.disturbance.final, rel=1e-6)
    np.testing.assert_allclose(held.disturbance.deviation, free.disturbance.deviation, atol=1e-12)
