"""What input shapers and moves leave of a mode whose frequency is not quite the expected one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import InputShaper
from ...shaping.checks import finite, positive
from ...shaping.drawing import draw
from ...shaping.frozen import Frozen
from ...shaping.real_numbers import shown
from ...shaping.trajectory import Motion, as_trajectory
from ...shaping.trajectory_checks import finite_array
from .vibration import residual_vibration

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...shaping.pieces import FloatArray


@dataclass(frozen=True, eq=False)
class ShaperSensitivity(Frozen):
    """Sensitivity curves of M shapers and moves.

    Attributes
    ----------
    names : tuple of M str
    ratios : (N,) array
        Frequency of the mode over that expected, increasing.
    residual : (M, N) array
        Amplitude at the end, over that which a step of the same size leaves.
    durations : (M,) array
        By which a shaper makes a command longer; of a move, its own.
    frequency_hz, damping : float
        Of the mode as expected.
    """

    names: tuple[str, ...]
    ratios: FloatArray
    residual: FloatArray
    durations: FloatArray
    frequency_hz: float
    damping: float

    def insensitivity(self, level: float = 0.05) -> FloatArray:
        """Return the width of the band of ratios about 1 in which no more than `level` is left.

        Between the points of the curve it is taken as straight, and the band ends with the curve:
        (M,), 0 where more is left at 1.
        """
        level = positive("level", level)
        return np.array([self._width(row - level) for row in self.residual])

    def _width(self, excess: FloatArray) -> float:
        if np.interp(1.0, self.ratios, excess) > 1e-12:
            return 0.0
        outside = self.ratios[excess > 1e-12]
        low = outside[outside < 1.0].max(initial=-np.inf)
        high = outside[outside > 1.0].min(initial=np.inf)
        ends = []
        for edge, step in ((low, 1), (high, -1)):
            if not np.isfinite(edge):
                ends.append(self.ratios[0] if step == 1 else self.ratios[-1])
                continue
            i = int(np.searchsorted(self.ratios, edge))
            j = i + step
            part = excess[i] / (excess[i] - excess[j])
            ends.append(edge + part * (self.ratios[j] - edge))
        return float(ends[1] - ends[0])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the curves; without an Axes in pyplot's current ones."""
        drawn: Axes = draw(self, ax)
        return drawn

    def __repr__(self) -> str:
        return (
            f"ShaperSensitivity({', '.join(self.names)}; frequency_hz={self.frequency_hz!r}, "
            f"damping={self.damping!r})"
        )


def sensitivity_of_shapers(
    shapers: Mapping[str, InputShaper | Motion],
    frequency_hz: float,
    damping: float = 0.0,
    *,
    ratios: ArrayLike | None = None,
) -> ShaperSensitivity:
    """Return what shapers and moves leave of a mode, over its frequency's ratio to that expected.

    A step of the command, shaped, leaves Σ A_i·e^(p·(t_n − t_i)) of what the step alone leaves,
    with the mode's pole p; a move leaves A/R as in `residual_vibration`. So both are on one scale.
    A shaped move leaves the product of the two.

    Parameters
    ----------
    shapers : mapping of str to InputShaper, Trajectory or Transfer
        By the names that the curves are to have; motions are from rest to rest.
    frequency_hz : float
        Natural frequency as expected, positive.
    damping : float, optional
        ζ, from 0 to below 1, the same at all frequencies.
    ratios : (N,) array, optional
        Increasing and positive. Default: 401 from 0.5 to 1.5.

    Returns
    -------
    ShaperSensitivity

    Examples
    --------
    >>> from jounce.shaping import input_shaper
    >>> curves = sensitivity_of_shapers(
    ...     {kind: input_shaper(kind, 5.0) for kind in ("ZV", "ZVD", "EI")}, 5.0
    ... )
    >>> curves.insensitivity(0.05).round(3)
    array([0.064, 0.287, 0.399])
    """
    if not isinstance(shapers, Mapping) or not shapers:
        raise TypeError(
            f"shapers = {shown(shapers)}: expected a mapping of names to shapers and moves, such "
            "as {'ZV': input_shaper('ZV', 5.0)}"
        )
    frequency, zeta = positive("frequency_hz", frequency_hz), finite("damping", damping)
    at = finite_array("ratios", np.linspace(0.5, 1.5, 401) if ratios is None else ratios)
    if at.ndim != 1 or not at.size or not at[0] > 0.0 or not (np.diff(at) > 0.0).all():
        raise ValueError(f"ratios = {shown(ratios)}: expected positive numbers that increase")
    curves, durations = [], []
    for name, shaper in shapers.items():
        if isinstance(shaper, InputShaper):
            curves.append(shaper.residual(frequency * at, zeta))
            durations.append(shaper.duration)
            continue
        move = as_trajectory(shaper, f"shapers[{name!r}]")
        size = abs(float(move.end_state[0] - move.start_state[0]))
        if not size:
            raise ValueError(f"shapers[{name!r}] goes nowhere: expected a move of some distance")
        curves.append(residual_vibration(move, frequency * at, zeta) / size)
        durations.append(move.duration)
    return ShaperSensitivity(
        tuple(map(str, shapers)), at, np.array(curves), np.array(durations), frequency, zeta
    )
