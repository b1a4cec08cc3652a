"""Sweeps on a Dask cluster: the numbers of one process, also when a worker dies."""

import os

import numpy as np
import pytest
from swept_axis import AXIS

from jounce.app import sweep

distributed = pytest.importorskip("distributed")
SLOW = os.environ.get("JOUNCE_TIER") == "slow"


@pytest.mark.slow
def test_a_cluster_that_loses_a_worker_gives_the_same_numbers(tmp_path):
    axis = tmp_path / "axis.toml"
    axis.write_text(AXIS, encoding="utf-8")
    count = 32 if SLOW else 8
    parameters = {
        "limits.drive.jerk": [f"{jerk} deg/s^3" for jerk in np.linspace(300.0, 900.0, count)],
        "controller.specification.crossover": [f"{hz} Hz" for hz in np.linspace(1.5, 2.5, 8)],
    }
    asked = {"figures": ["phase_margin", "modulus_margin", "duration"]}
    with (
        distributed.LocalCluster(
            n_workers=3 if SLOW else 2,
            threads_per_worker=1,
            dashboard_address=":0",
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        first = next(iter(cluster.workers.values()))
        client.loop.call_later(0.2, first.kill)
        there = sweep(axis, parameters, client=client, output=tmp_path / "a.zarr", **asked)
    here = sweep(axis, parameters, workers=1, **asked)
    assert there.dataset["done"].values.all()
    for name in asked["figures"]:
        assert np.array_equal(there.values(name), here.values(name))
