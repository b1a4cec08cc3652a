"""Input shapers over sampled commands, and shaped moves, as C: Python's to the last bit."""

import every_block
import numpy as np
import pytest
from firmware import driven
from fmus import Host, fmu_of, needs_compiler

from jounce.fmu import SampledShaper, export_fmu
from jounce.fmu.exporting import export_c as writing
from jounce.shaping import input_shaper


@needs_compiler
def test_random_commands_are_shaped_as_python_does(tmp_path, monkeypatch):
    monkeypatch.setattr(writing, "measure", lambda *_: None)
    sampled = every_block.sampled_shaper()
    command = np.cumsum(np.random.default_rng(1).normal(size=2000))
    [made] = driven(sampled, tmp_path / "c", {"command": command}, ("shaped",))
    np.testing.assert_array_equal(made, sampled.run(command))
    times, parts = sampled.shaper.times, sampled.shaper.amplitudes
    at = sampled.dt * np.arange(2000.0)
    straight = [np.interp(at - time, at, command) for time in times]  # straight between samples
    np.testing.assert_allclose(made, parts @ np.array(straight), atol=1e-11)


def test_a_delay_of_whole_samples_is_kept():
    sampled = SampledShaper(input_shaper("ZVD", 5.0), 0.01)
    delays, weights = sampled.parts
    assert delays.tolist() == [0, 10, 20]
    np.testing.assert_allclose(weights, [0.25, 0.5, 0.25], rtol=1e-15)
    assert sampled.on_grid.residual(5.0) < 1e-14
    assert SampledShaper(input_shaper("ZV", 5.0, 0.03), 1e-3).on_grid.residual(5.0, 0.03) < 1e-3


@needs_compiler
def test_a_shaped_move_is_pythons_in_an_fmu_too():
    move = every_block.shaped_trajectory()
    host = Host(fmu_of(every_block.shaped_trajectory, "3.0")).run()
    h = move.duration / 512
    made = host.record(np.full(512, h), "position", "velocity", "acceleration")
    host.close()
    times = np.cumsum(np.full(512, h))
    expected = [move(times, k) for k in range(3)]
    np.testing.assert_allclose(made, expected, atol=1e-12)


def test_one_that_lasts_too_long_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"dt = 1e-07: the shaper would last 1e\+06 samples"):
        SampledShaper(input_shaper("ZV", 5.0), 1e-7)
    with pytest.raises(TypeError, match=r"shaper = 5: expected input_shaper"):
        SampledShaper(5, 1e-3)
    with pytest.raises(TypeError, match="got InputShaper: expected one of"):
        export_fmu(input_shaper("ZV", 5.0), tmp_path / "a.fmu", platforms=[])
