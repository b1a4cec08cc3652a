"""Filters of a controller: notch, lead-lag and low-pass."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from ..shaping.checks import finite, positive, whole
from ..shaping.real_numbers import shown

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class Notch:
    """A notch, 1 at frequency 0.

        (s² + 2ζ_z·ω_z·s + ω_z²)/(s² + 2ζ_p·ω_p·s + ω_p²)·(ω_p/ω_z)²

    With equal frequencies its depth is ζ_z/ζ_p. A sampled one keeps `zero_hz` exactly.

    Parameters
    ----------
    zero_hz : float
        Positive.
    pole_hz : float, optional
        Positive. Default: `zero_hz`; another one makes the notch skew.
    zero_damping : float
        ζ_z ≥ 0.
    pole_damping : float
        ζ_p, positive.
    """

    zero_hz: float
    pole_hz: float | None = None
    _: KW_ONLY
    zero_damping: float
    pole_damping: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "zero_hz", positive("zero_hz", self.zero_hz))
        pole = self.zero_hz if self.pole_hz is None else positive("pole_hz", self.pole_hz)
        object.__setattr__(self, "pole_hz", pole)
        object.__setattr__(self, "zero_damping", finite("zero_damping", self.zero_damping))
        if self.zero_damping < 0.0:
            raise ValueError(f"zero_damping = {shown(self.zero_damping)}: expected a number ≥ 0")
        object.__setattr__(self, "pole_damping", positive("pole_damping", self.pole_damping))

    @property
    def prewarp_hz(self) -> float:
        """Frequency that a sampled one keeps."""
        return self.zero_hz

    def polynomials(self) -> tuple[list[float], list[float]]:
        """Return numerator and denominator, highest power first."""
        zero, pole = 2.0 * pi * self.zero_hz, 2.0 * pi * (self.pole_hz or self.zero_hz)
        gain = (pole / zero) ** 2
        above = [gain, gain * 2.0 * self.zero_damping * zero, gain * zero * zero]
        return above, [1.0, 2.0 * self.pole_damping * pole, pole * pole]

    def transfer(self) -> control.TransferFunction:
        """Return it as a python-control system."""
        return _transfer(self)


@dataclass(frozen=True)
class LeadLag:
    """A lead or lag element (1 + s/ω_z)/(1 + s/ω_p); a sampled one keeps √(ω_z·ω_p).

    Parameters
    ----------
    zero_hz, pole_hz : float
        Positive; a lead has its zero below its pole.
    """

    zero_hz: float
    pole_hz: float

    def __post_init__(self) -> None:
        for name in ("zero_hz", "pole_hz"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @property
    def prewarp_hz(self) -> float:
        """Frequency that a sampled one keeps."""
        return sqrt(self.zero_hz) * sqrt(self.pole_hz)

    def polynomials(self) -> tuple[list[float], list[float]]:
        """Return numerator and denominator, highest power first."""
        return [1.0 / (2.0 * pi * self.zero_hz), 1.0], [1.0 / (2.0 * pi * self.pole_hz), 1.0]

    def transfer(self) -> control.TransferFunction:
        """Return it as a python-control system."""
        return _transfer(self)


@dataclass(frozen=True)
class LowPass:
    """A low-pass filter, ω²/(s² + 2ζω·s + ω²), or of order 1, ω/(s + ω).

    Parameters
    ----------
    corner_hz : float
        Positive; a sampled one keeps it.
    order : 1 or 2, optional
    damping : float, optional
        ζ > 0 of order 2. Default: 0.7.
    """

    corner_hz: float
    order: int = 2
    damping: float = 0.7

    def __post_init__(self) -> None:
        object.__setattr__(self, "corner_hz", positive("corner_hz", self.corner_hz))
        object.__setattr__(self, "order", whole("order", self.order, 1, 2))
        object.__setattr__(self, "damping", positive("damping", self.damping))

    @property
    def prewarp_hz(self) -> float:
        """Frequency that a sampled one keeps."""
        return self.corner_hz

    def polynomials(self) -> tuple[list[float], list[float]]:
        """Return numerator and denominator, highest power first."""
        omega = 2.0 * pi * self.corner_hz
        if self.order == 1:
            return [omega], [1.0, omega]
        return [omega * omega], [1.0, 2.0 * self.damping * omega, omega * omega]

    def transfer(self) -> control.TransferFunction:
        """Return it as a python-control system."""
        return _transfer(self)


Filter = Notch | LeadLag | LowPass


def _transfer(element: Filter) -> control.TransferFunction:
    import control

    numerator, denominator = element.polynomials()
    return control.tf(np.array(numerator), np.array(denominator), name="filter")
