"""An input shaper over a command that comes sample by sample, as a noun and as a block."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import InputShaper
from ...shaping.checks import of_kind, positive
from ...shaping.frozen import Frozen
from ...shaping.pieces import FloatArray
from ...shaping.real_numbers import real_array
from .blocks import Block, output, sample_time_constant, signal
from .linear_blocks import table_rows
from .loop_blocks import HELD
from .motion_blocks import SAMPLING

LONGEST = 100_000
"""Most samples that a shaper may remember."""

_NEARLY = 1e-9  # of a sample: as near to one, a delay is whole


@dataclass(frozen=True)
class SampledShaper(Frozen):
    """An input shaper that runs once every dt on a sampled command, to be exported.

        shaped_k = Σ_i weights[i]·command_{k − delays[i]}

    A delay between two samples is shared out to both, which is exact for commands that are
    straight between samples; `on_grid.residual` tells what that leaves of a mode. Before the
    first sample the command has stood still.

    Parameters
    ----------
    shaper : InputShaper
    dt : float
        Sample time, positive.

    Raises
    ------
    ValueError
        For a shaper that lasts longer than 100,000 samples.

    Examples
    --------
    >>> from jounce.shaping import input_shaper
    >>> SampledShaper(input_shaper("ZV", 2.0), dt=0.1).run([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    array([0.  , 0.5 , 0.5 , 0.75, 1.  , 1.  ])
    """

    shaper: InputShaper
    dt: float

    def __post_init__(self) -> None:
        of_kind("shaper", self.shaper, InputShaper, "input_shaper(kind, frequency_hz, damping)")
        object.__setattr__(self, "dt", positive("dt", self.dt))
        if not self.shaper.duration / self.dt <= LONGEST:
            raise ValueError(
                f"dt = {self.dt!r}: the shaper would last {self.shaper.duration / self.dt:.3g} "
                f"samples; expected at most {LONGEST}: use a longer sample time"
            )

    @cached_property
    def parts(self) -> tuple[Any, FloatArray]:
        """Delays in samples, increasing, and the weight of each."""
        late = self.shaper.times / self.dt
        whole = np.floor(late + _NEARLY)
        rest = np.where(np.abs(late - whole) <= _NEARLY, 0.0, late - whole)
        delays = np.concatenate([whole, whole + 1.0]).astype(int)
        weights = np.concatenate(
            [self.shaper.amplitudes * (1.0 - rest), self.shaper.amplitudes * rest]
        )
        distinct, place = np.unique(delays[weights > 0.0], return_inverse=True)
        return distinct, np.bincount(place, weights[weights > 0.0]).astype(float)

    @property
    def on_grid(self) -> InputShaper:
        """The shaper that is run: parts at whole samples."""
        delays, weights = self.parts
        return InputShaper(self.dt * delays, weights)

    def run(self, command: ArrayLike) -> FloatArray:
        """Return the shaped command of N samples, as the exported block gives it."""
        given = np.atleast_1d(real_array("command", command))
        total = np.zeros(len(given))
        for delay, weight in zip(*self.parts, strict=True):
            past = np.full(len(given), given[0])
            past[delay:] = given[: max(len(given) - delay, 0)]
            total += weight * past
        return total


def shaper_block(sampled: SampledShaper, name: str, unit: str) -> Block:
    """Return an input shaper as a block with a fixed sample time."""
    delays, weights = sampled.parts
    return Block(
        name,
        f"Input shaper of {len(sampled.shaper.times)} parts over a sampled command",
        (
            sample_time_constant(sampled.dt),
            signal("command", "Command, taken over at every sample", unit),
            output(
                "shaped",
                "Command behind the shaper",
                unit,
                variability="discrete",
                initial_dependencies={"command": "constant"},
            ),
        ),
        "input_shaper",
        constants={
            "SAMPLE_TIME": repr(sampled.dt),
            "N_PARTS": str(len(delays)),
            "N_RING": str(int(delays[-1]) + 1),
        },
        tables={"part_delay": table_rows(delays), "part_weight": table_rows(weights)},
        memory=int(delays[-1]) + 1,
        sample_time=sampled.dt,
        stop_time=max(10.0 * sampled.shaper.duration, 1000 * sampled.dt),
        step=sampled.dt,
        notes=(SAMPLING, HELD),
    )
