"""A transfer has a trajectory, answers as that does, and is taken wherever one is."""

import copy
import pickle
from dataclasses import FrozenInstanceError, replace

import control
import matplotlib.pyplot as plt
import numpy as np
import pytest

from jounce.analysis.frequency_view import (
    cascaded_lags,
    corner_omega,
    fft_frequency_response,
    frequency_response,
    null_omegas,
    residual_vibration,
    rollover_db_per_decade,
)
from jounce.fmu import SampledLoop, cosimulate, export_c, export_ssp
from jounce.plant import PID, Inertia, InertiaFeedforward, ServoLoop, respond
from jounce.plots import draw
from jounce.plots.motions import plot_motions
from jounce.shaping import (
    JerkFilter,
    Limits,
    Trajectory,
    Transfer,
    binding_limits,
    certify,
    min_time_move,
    min_time_transfer,
    min_time_transfers,
    synchronize,
    velocity_transfer,
)

LIMITS = Limits(1.0, 2.0, 9.0)
PASSING = min_time_transfer((0.5, 0.3, 0.1), (2.0, 0.2), LIMITS)
RESTING = min_time_transfer(0.5, 2.0, LIMITS)
LOOP = ServoLoop(Inertia(1.0), PID(4.0, 1.0, 4.0), InertiaFeedforward(1.0))
FILTER = JerkFilter(2.0, 3)


def numbers(result):
    """Return a result as something to be compared with ==."""
    if isinstance(result, np.ndarray):
        return result.tolist()
    if isinstance(result, tuple | list):
        return [numbers(part) for part in result]
    if isinstance(result, Trajectory):
        return [numbers(each) for each in vars(Trajectory(
            result.breaks, result.states, result.durations, result.end_state, result.coasting
        )).values()]  # fmt: skip
    return result


OMEGA = np.array([0.5, 3.0, 20.0])
DOORS = {
    "then": lambda m: min_time_move(1.0, LIMITS).then(m),
    "after itself": lambda m: m.then(m, dwell=0.5),
    "filter": lambda m: FILTER.respond(m, 0.01).states,
    "steady state": lambda m: FILTER.steady_state(m, 1),
    "binding": lambda m: binding_limits(m, LIMITS),
    "certificate": lambda m: certify(m, LIMITS).gap,
    "loop": lambda m: LOOP.respond(m, 0.01).outputs,
    "filtered loop": lambda m: LOOP.respond(m, 0.01, jerk_filter=FILTER).states,
    "system": lambda m: respond(control.tf([1.0], [1.0, 1.0]), m, 0.01).outputs,
    "frequency": lambda m: frequency_response(m, OMEGA).response,
    "fft": lambda m: fft_frequency_response(m, 0.01).response,
    "corner": corner_omega,
    "rollover": rollover_db_per_decade,
    "lags": lambda m: cascaded_lags(m, OMEGA).lags,
    "nulls": lambda m: null_omegas(m, 40.0),
    "vibration": lambda m: residual_vibration(m, [2.0, 5.0], 0.02),
    "sampled loop": lambda m: SampledLoop(m, LOOP, 0.01).trajectory,
    "block": lambda m: cosimulate({"m": m}, [], dt=0.1, duration=1.0).signals["m.velocity"],
    "source": lambda m: cosimulate(
        {"lag": control.tf([1.0], [1.0, 1.0], inputs="u", outputs="y", name="lag")},
        [(m, "lag.u")],
        dt=0.1,
        duration=1.0,
    ).signals["lag.y"],
    "straight line": lambda m: [
        axis.end_state for axis in synchronize([m, (0.0, 3.0, LIMITS)], "straight-line")
    ],
    "as one": lambda m: Transfer(m, LIMITS).trajectory,
}


@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_whatever_takes_a_trajectory_takes_a_transfer(door):
    assert numbers(door(RESTING)) == numbers(door(RESTING.trajectory))


def test_a_transfer_is_exported_as_its_trajectory_is(tmp_path):
    for name, motion in (("one", PASSING), ("other", PASSING.trajectory)):
        export_c(motion, tmp_path / name, name="motion")
        export_ssp(tmp_path / f"{name}.ssp", motion, LOOP, dt=0.01, platforms=[])
    one, other = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.*")}
        for folder in (tmp_path / "one", tmp_path / "other")
    )
    assert one == other


def test_a_transfer_is_drawn_as_its_trajectory_is():
    for picture in (draw, lambda m: m.plot(), lambda m: m.plot(LIMITS, unit="mm")):
        figures = [picture(motion) for motion in (PASSING, PASSING.trajectory)]
        drawn = [[ax.lines[0].get_xydata().tolist() for ax in f.axes] for f in figures]
        assert drawn[0] == drawn[1]
    ax = plot_motions({"there": PASSING}, 1, ax=plt.figure().add_subplot())
    assert ax.lines[0].get_xydata()[:, 1].max() == PASSING.peak("velocity")
    plt.close("all")


def made_in_every_way():
    """Yield transfers of the core, from a batch, copied, and made of a trajectory."""
    yield PASSING
    yield min_time_transfers([[0.5, 0.3, 0.1]], [[2.0, 0.2]], LIMITS)[0]
    yield from (copy.copy(PASSING), copy.deepcopy(PASSING), pickle.loads(pickle.dumps(PASSING)))
    yield Transfer(PASSING.trajectory, LIMITS)
    yield replace(PASSING, limits=LIMITS)


@pytest.mark.parametrize("transfer", list(made_in_every_way()))
def test_a_transfer_answers_as_its_trajectory_does(transfer):
    motion, times = transfer.trajectory, np.linspace(-1.0, 3.0, 41)
    assert type(motion) is Trajectory
    assert transfer.trajectory is motion
    assert transfer.duration == motion.duration == PASSING.duration
    for name in ("order", "start_time", "end_time", "coasting"):
        assert getattr(transfer, name) == getattr(motion, name)
    for name in ("breaks", "states", "durations", "start_state", "end_state", "switch_times"):
        assert getattr(transfer, name).tolist() == getattr(motion, name).tolist()
    assert transfer(0.25) == motion(0.25)
    assert transfer(times, "jerk").tolist() == motion(times, 3).tolist()
    assert transfer.evaluate(times).tolist() == motion.evaluate(times).tolist()
    assert transfer.sample(0.1)[1].tolist() == motion.sample(0.1)[1].tolist()
    assert transfer.extremes(2) == motion.extremes(2)
    assert transfer.peak("jerk") == motion.peak("jerk") == 9.0
    assert transfer.violation(transfer.limits) == motion.violation(LIMITS) <= 1e-12
    assert transfer.derivative("velocity")(0.3) == motion(0.3, 1)
    assert transfer.until(0.4).end_state.tolist() == motion.until(0.4).end_state.tolist()
    assert transfer.delay(1.0)(1.3) == motion(0.3)
    assert {"trajectory", "limits", "peak", "states", "then"} <= set(dir(transfer))


def test_what_a_transfer_does_not_have_is_said():
    with pytest.raises(AttributeError, match="no attribute 'jolt'"):
        PASSING.jolt  # noqa: B018
    assert not hasattr(PASSING, "__array__")
    for name in ("trajectory", "limits", "inside_after", "duration", "states", "new"):
        with pytest.raises(FrozenInstanceError):
            setattr(PASSING, name, None)


def test_what_a_transfer_is_made_of_is_checked():
    with pytest.raises(TypeError, match="trajectory = 3: expected a Trajectory"):
        Transfer(3, LIMITS)
    with pytest.raises(TypeError, match="limits = None: expected Limits"):
        Transfer(PASSING.trajectory, None)
    with pytest.raises(ValueError, match="inside_after = nan: expected a finite number"):
        Transfer(PASSING.trajectory, LIMITS, float("nan"))


@pytest.mark.parametrize("door", [LOOP.respond, FILTER.respond], ids=["loop", "filter"])
def test_anything_else_is_refused_in_one_line(door):
    with pytest.raises(TypeError, match=r"^(trajectory|command) = 3: expected a Trajectory"):
        door(3, 0.1)


def test_a_velocity_transfer_leads_into_the_next_motion():
    first = velocity_transfer(0.0, 0.5, LIMITS)
    both = first.then(min_time_transfer((0.0, 0.5), 3.0, LIMITS))
    assert both.end_state[0] == pytest.approx(first.end_state[0] + 3.0, rel=1e-15)
    assert both.violation(LIMITS) <= 1e-12
    with pytest.raises(ValueError, match=r"velocity would jump from 0\.5 to 0 at the joint"):
        first.then(RESTING)
