"""Several measurements of one axis, at other positions or on other days: the worst, the spread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shaping.frozen import Frozen
from ...shaping.told import Told
from .margins_of_data import measured_margins
from .measured_response import MeasuredResponse
from .result import BARRED, MeasuredMargins


@dataclass(frozen=True, repr=False)
class RepeatedMargins(Told, Frozen):
    """Margins of one controller on several measurements, by name.

    Attributes
    ----------
    margins : mapping of str to MeasuredMargins
    """

    margins: Mapping[str, MeasuredMargins]

    @property
    def stable(self) -> bool | None:
        """False where one loop is unstable, None where one cannot be told, else True."""
        verdicts = [each.stable for each in self.margins.values()]
        return False if False in verdicts else None if None in verdicts else True

    def worst(self, name: str) -> tuple[str, float]:
        """Return the measurement with the smallest margin, or the highest peak, and its value."""
        told = self._told(name)
        if name.endswith("peak"):
            return max(told.items(), key=lambda item: item[1])
        return min(told.items(), key=lambda item: item[1])

    def spread(self, name: str) -> tuple[float, float]:
        """Return the standard deviation of a margin over the measurements, and that by noise."""
        values = np.array(list(self._told(name).values()))
        sigmas = np.array([getattr(m, f"{name}_sigma") for m in self.margins.values()])
        by_noise = float(np.sqrt(np.nanmean(sigmas**2)))
        return float(values.std(ddof=1)) if len(values) > 1 else 0.0, by_noise

    def _told(self, name: str) -> dict[str, float]:
        if name not in BARRED:
            raise ValueError(f"margin {name!r} is not known: expected one of {', '.join(BARRED)}")
        told = {key: float(getattr(each, name)) for key, each in self.margins.items()}
        told = {key: value for key, value in told.items() if np.isfinite(value)}
        if not told:
            raise ValueError(f"{name} was not measured in any of {', '.join(self.margins)}")
        return told

    def __str__(self) -> str:
        lines = []
        for name in BARRED:
            try:
                where, value = self.worst(name)
            except ValueError:
                continue
            spread, noise = self.spread(name)
            lines.append(f"{name}: {value:.4g} ({where}), spread {spread:.2g}, noise {noise:.2g}")
        return "\n".join(lines)


def repeated_margins(
    measured: Mapping[str, MeasuredResponse], controller: Any = None, *, measured_with: Any = None
) -> RepeatedMargins:
    """Return the margins of one controller on each of several measurements.

    Parameters
    ----------
    measured : mapping of str to MeasuredResponse
        By name: of a position, a day, a machine.
    controller, measured_with : optional
        As in `loop_margins`.

    Returns
    -------
    RepeatedMargins
        Phases in degrees, gains in dB, frequencies in Hz, as `MeasuredMargins` has them.

    Raises
    ------
    TypeError, ValueError
        Where no measurement is given, or they have no names; else as `loop_margins` does.
    """
    if not isinstance(measured, Mapping):
        raise TypeError(
            f"measured is a {type(measured).__name__}: expected responses by name, "
            "{'monday': response, …}"
        )
    if not measured:
        raise ValueError("no measurement is given: expected one or more, {'name': response}")
    return RepeatedMargins(
        {
            name: measured_margins(each, controller, measured_with=measured_with)
            for name, each in measured.items()
        }
    )
