"""What acts on an axis during a move or a tracking: torques, random ones too, and noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plant import ServoLoop, Spectrum, Wind, noise_realisation, wind_realisation
from ..plant.disturbances import checked_disturbances
from ..plant.run import samples_within
from ..shaping.checks import finite, whole
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray

_HELD = 1e-3  # s for which random torques are held on an axis under a continuous controller
_APART = 32  # bits between the seeds of two sources


@dataclass(frozen=True)
class Disturbances(Frozen):
    """Torques and errors of the encoder, the same ones for the same seed.

    Parameters
    ----------
    torques : tuple, optional
        TorqueSteps, SampledTorque, TorqueSine; Wind and Spectrum as one of their courses, held
        for a sample of a digital controller, for 1 ms under a continuous one.
    encoder_noise : tuple, optional
        Standard deviations of independent errors of each sample, and spectra of errors; of a
        digital controller.
    seed : int, optional
        From 0 on.
    """

    torques: tuple[Any, ...] = ()
    encoder_noise: tuple[float | Spectrum, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("torques", "encoder_noise"):
            given = getattr(self, name)
            several = tuple(given) if isinstance(given, list | tuple) else (given,)
            object.__setattr__(self, name, several)
        checked_disturbances([t for t in self.torques if not isinstance(t, Wind | Spectrum)])
        for each in self.encoder_noise:
            if not isinstance(each, Spectrum):
                finite("encoder_noise", each)
        whole("seed", self.seed, 0, 2**_APART - 1)

    @property
    def until(self) -> float:
        """Time of the last change of a torque that is given by its times."""
        times = [float(t.times[-1]) for t in self.torques if hasattr(t, "times")]
        return max(times, default=0.0)

    def acting(self, loop: ServoLoop, duration: float) -> dict[str, Any]:
        """Return what `loop.respond` takes of it, for a response of some duration."""
        dt = loop.controller_noun.sample_time
        torques = []
        for i, torque in enumerate(self.torques):
            if isinstance(torque, Wind | Spectrum):
                held = dt or _HELD
                torque = wind_realisation(torque, duration, held, seed=self._seed(i))
            torques.append(torque)
        return {"disturbance": torques or None, "noise": self._errors(dt, duration)}

    def _errors(self, dt: float | None, duration: float) -> FloatArray | None:
        if not self.encoder_noise:
            return None
        if dt is None:
            raise ValueError(
                "encoder noise in a continuous loop: noise comes with each sample; give the "
                "controller a sample_time"
            )
        count = samples_within(duration, dt)
        total = np.zeros(count)
        for i, noise in enumerate(self.encoder_noise, start=len(self.torques)):
            if isinstance(noise, Spectrum):
                total += noise_realisation(noise, count, dt, seed=self._seed(i))
            else:
                total += noise * np.random.default_rng(self._seed(i)).standard_normal(count)
        return total

    def _seed(self, source: int) -> int:
        return self.seed + (source << _APART)
