"""What the FMU owes its host: phases, bounds, messages, snapshots, several instances."""

import ctypes
import math

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmus import VERSIONS, Host, fmu_of, needs_compiler
from tiers import some

from jounce.fmu import SampledController
from jounce.plant import PID, Inertia
from jounce.shaping import CommandFollower, JerkFilter, Limits, min_time_move

pytestmark = needs_compiler

DT = 0.01


def follower():
    return CommandFollower(
        Limits(velocity=1.0, acceleration=2.0), dt=DT, jerk_filter=JerkFilter(3.0, 2)
    )


def axis():
    return Inertia(2.0)


def controller():
    return SampledController(PID(1.0, 2.0, 3.0), DT)


def trajectory():
    return min_time_move(1.0, Limits(velocity=1.0, acceleration=2.0))


MAKERS = (follower, axis, controller, trajectory)

both_versions = pytest.mark.parametrize("version", VERSIONS)


@both_versions
@pytest.mark.parametrize("make", some(MAKERS, 2))
def test_start_values_in_the_description_are_those_of_the_binary(make, version):
    host = Host(fmu_of(make, version))
    started = [v for v in host.description.modelVariables if v.start is not None]
    assert started
    for variable in started:
        assert host.get(variable.name) == [float(variable.start)], variable.name
    host.close()


@both_versions
def test_a_wrong_token_is_refused(version):
    with pytest.raises(Exception, match="nstantiat"):
        Host(fmu_of(axis, version), token="{00000000-0000-4000-8000-000000000000}")


@both_versions
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused_and_change_nothing(version, value):
    host = Host(fmu_of(axis, version)).run(u=3.0)
    assert "expected a finite number" in host.refused(host.set, u=value)
    assert host.get("u") == [3.0]
    host.step(1.0)
    assert host.get("y_rate") == [1.5]
    for h in (value, 0.0, -0.1):
        assert "expected a positive, finite time" in host.refused(host.step, h)
    assert host.get("y_rate") == [1.5]
    host.close()


@both_versions
def test_minimum_and_maximum_are_enforced(version):
    host = Host(fmu_of(follower, version))
    bounds = {v.name: (v.min, v.max) for v in host.description.modelVariables}
    assert float(bounds["velocity_max"][0]) > 0.0
    assert float(bounds["velocity_min"][1]) < 0.0
    message = host.refused(host.set, velocity_max=-2.5)
    assert message == "velocity_max = -2.5 is below its minimum 2.22507e-308"
    assert "is above its maximum" in host.refused(host.set, acceleration_min=0.0)
    assert host.get("velocity_max", "acceleration_min") == [1.0, -2.0]
    host.close()


@both_versions
def test_outputs_constants_and_unknown_references_cannot_be_set(version):
    host = Host(fmu_of(controller, version)).run()
    assert host.refused(host.set, u=1.0) == "u: cannot be set"
    assert host.refused(host.set, sample_time=1.0) == "sample_time: cannot be set"
    host.reference["nothing"] = 99
    assert "unknown" in host.refused(host.set, nothing=1.0)
    assert "unknown" in host.refused(host.get, "nothing")
    host.close()


@both_versions
def test_calls_out_of_order_are_refused(version):
    host = Host(fmu_of(axis, version))
    assert "DoStep is not allowed in this phase: initialization mode" in host.refused(host.step, DT)
    host.run()
    assert "step mode" in host.refused(host.fmu.enterInitializationMode)
    host.step(DT)
    host.fmu.terminate()
    assert "terminated" in host.refused(host.step, DT)
    host.get("y")
    host.close()


@both_versions
def test_steps_that_do_not_follow_each_other_are_refused(version):
    host = Host(fmu_of(axis, version), stop=1.0).run()
    host.step(0.5)
    host.time = 0.9
    assert "communication point = 0.9: expected the end" in host.refused(host.step, 0.1)
    host.time = 0.5 + 1e-12
    host.step(0.5)
    assert "beyond the stop time 1" in host.refused(host.step, 0.5)
    host.close()


@both_versions
def test_logging_tells_events_only_where_it_is_wanted(version):
    quiet, loud = (Host(fmu_of(axis, version), logging=on).run() for on in (False, True))
    assert quiet.messages == []
    assert loud.messages == ["initialized"]
    quiet.fmu.setDebugLogging(True, ["logEvents"])
    quiet.fmu.reset()
    assert quiet.messages == ["reset"]
    with pytest.raises(FMICallException):
        quiet.fmu.setDebugLogging(True, ["logPoetry"])
    assert quiet.messages[1:] == ["unknown log category"]
    quiet.close()
    loud.close()


def drive(host, count, seed=0):
    """Return what an instance puts out under random inputs."""
    names = [v.name for v in host.description.modelVariables if v.causality == "output"]
    inputs = [v.name for v in host.description.modelVariables if v.causality == "input"]
    rng = np.random.default_rng(seed)
    given = {name: rng.normal(size=count) for name in inputs}
    return host.record(rng.uniform(0.3, 2.5, count) * DT, *names, **given)


@both_versions
@pytest.mark.parametrize("make", MAKERS)
def test_reset_begins_again(make, version):
    host = Host(fmu_of(make, version)).run()
    first = drive(host, 30)
    host.fmu.reset()
    host.initialize()
    host.run()
    np.testing.assert_array_equal(drive(host, 30), first)
    host.close()


@pytest.mark.parametrize("make", MAKERS)
def test_two_instances_do_not_touch_each_other(make):
    alone = Host(fmu_of(make, "3.0")).run()
    expected = drive(alone, 20, seed=1), drive(alone, 20, seed=2)
    alone.close()
    one, other = (Host(fmu_of(make, "3.0")).run() for _ in range(2))
    drive(other, 7, seed=9)
    np.testing.assert_array_equal(drive(one, 20, seed=1), expected[0])
    drive(other, 7, seed=8)
    np.testing.assert_array_equal(drive(one, 20, seed=2), expected[1])
    one.close()
    other.close()


def snapshot_calls(host):
    fmu = host.fmu
    if host.old:
        return fmu.getFMUstate, fmu.setFMUstate, fmu.freeFMUstate
    return fmu.getFMUState, fmu.setFMUState, fmu.freeFMUState


@both_versions
@pytest.mark.parametrize("make", MAKERS)
def test_a_snapshot_brings_everything_back(make, version):
    host = Host(fmu_of(make, version)).run()
    get, put, free = snapshot_calls(host)
    drive(host, 13)
    state, time = get(), host.time
    expected = drive(host, 20, seed=4)
    put(state)
    host.time = time
    np.testing.assert_array_equal(drive(host, 20, seed=4), expected)
    host.fmu.reset()
    put(state)
    host.time = time
    np.testing.assert_array_equal(drive(host, 20, seed=4), expected)
    free(state)
    host.close()


def packed(host):
    """Return the serialised state of an instance."""
    get, _, free = snapshot_calls(host)
    state = get()
    pack = host.fmu.serializeFMUstate if host.old else host.fmu.serializeFMUState
    data = pack(state)
    free(state)
    return bytes(data)


def unpack(host, data):
    call = host.fmu.deSerializeFMUstate if host.old else host.fmu.deserializeFMUState
    return call(data)


@both_versions
@pytest.mark.parametrize("make", MAKERS)
def test_a_serialised_state_goes_to_another_instance(make, version):
    one, other = (Host(fmu_of(make, version)).run() for _ in range(2))
    drive(one, 13)
    data, time = packed(one), one.time
    assert packed(one) == data
    expected = drive(one, 20, seed=4)
    _, put, free = snapshot_calls(other)
    state = unpack(other, data)
    put(state)
    free(state)
    other.time = time
    np.testing.assert_array_equal(drive(other, 20, seed=4), expected)
    one.close()
    other.close()


@both_versions
def test_a_serialised_state_of_another_fmu_or_a_damaged_one_is_refused(version):
    host, other = Host(fmu_of(axis, version)).run(), Host(fmu_of(controller, version)).run()
    data = packed(host)
    message = other.refused(unpack, other, data + bytes(4096))
    assert message == "the serialised state is not of this FMU"
    assert "expected a serialised state of" in host.refused(unpack, host, data[:-1])
    damaged = bytearray(data)
    damaged[-20] ^= 1
    assert host.refused(unpack, host, bytes(damaged)) == "the serialised state is damaged"
    host.close()
    other.close()


def test_null_instances_are_answered_with_an_error():
    for version, call in (("2.0", "fmi2Terminate"), ("3.0", "fmi3Terminate")):
        host = Host(fmu_of(axis, version))
        function = getattr(host.fmu.dll, call)
        function.restype, function.argtypes = ctypes.c_int, [ctypes.c_void_p]
        assert function(None) == 3
        host.close()
