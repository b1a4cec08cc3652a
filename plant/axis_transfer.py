"""Polynomials of an axis from torque to measured position, from its matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..shaping.pieces import FloatArray

_NOTHING = 1e-13  # of the largest coefficient, in the axis's own unit of time


def transfer_polynomials(axis: Any, sensor: str | None = None) -> tuple[FloatArray, FloatArray]:
    """Return numerator and denominator of g(s) of an Axis, highest power first, the lag included.

    Measured at its own sensor, or where `sensor` says, "motor" or "load".

    The determinants of M·s² + C·s + K and of its minors are taken at points of a circle, which
    give the coefficients to rounding; those that are rounding alone are 0.
    """
    (numerator,), denominator = numerators_of(axis, (sensor or axis.sensor,))
    return numerator, denominator


def numerators_of(axis: Any, sensors: Sequence[str]) -> tuple[list[FloatArray], FloatArray]:
    """Return the numerators for some sensors and the denominator that they have in common."""
    if axis.is_system:
        import control

        own = control.tf(axis.body.system)
        denominator = own.den_array[0, 0]
        numerators = [_without_rounding(own.num_array[0, 0], denominator)] * len(sensors)
    else:
        numerators, denominator = _polynomials(axis, sensors)
    if axis.current_lag:
        denominator = np.polymul([axis.current_lag, 1.0], denominator)
    return numerators, denominator


def _polynomials(axis: Any, sensors: Sequence[str]) -> tuple[list[FloatArray], FloatArray]:
    m = axis.mechanics
    size = len(m.mass)
    mean = axis.J  # determinants in units of J
    mass, damping, stiffness = m.mass / mean, m.damping / mean, m.stiffness / mean
    unit = _unit(mass, damping, stiffness)
    s = unit * np.exp(2j * np.pi * np.arange(2 * size + 1) / (2 * size + 1))[:, None, None]
    dynamic = mass * s * s + damping * s + stiffness
    cofactors, motor = _first_cofactors(dynamic), np.eye(size)[0]
    seen = [cofactors @ (motor if sensor == "motor" else m.load) for sensor in sensors]
    below = _coefficients(np.linalg.det(dynamic), unit)
    if not axis.spring:
        below[0] = 0.0
        if not (axis.viscous or axis.load_viscous):
            below[1] = 0.0
    above = [np.trim_zeros(_coefficients(each, unit)[::-1], "f") for each in seen]
    return above, mean * np.trim_zeros(below[::-1], "f")


def _without_rounding(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Return a numerator without leading coefficients that are rounding alone."""
    poles = np.abs(np.roots(denominator))
    moving = poles[poles > 1e-9 * poles.max(initial=0.0)]
    unit = float(np.exp(np.log(moving).mean())) if moving.size else 1.0
    sizes = np.abs(numerator) * unit ** np.arange(len(numerator) - 1.0, -1.0, -1.0)
    counts = np.flatnonzero(sizes > _NOTHING * sizes.max())
    return np.asarray(numerator[counts[0] :]) if counts.size else numerator


def _unit(*matrices: FloatArray) -> float:
    """Return a frequency about which the axis swings, 1 if it does not."""
    mass, _, stiffness = matrices
    lines = np.diag(stiffness) / np.diag(mass)
    lines = lines[lines > 0.0]
    return float(np.exp(0.5 * np.log(lines).mean())) if lines.size else 1.0


def _first_cofactors(matrices: Any) -> Any:
    """Return the first columns of the adjugates, (N, n)."""
    below, columns = matrices[:, 1:], np.arange(matrices.shape[1])
    cofactors = [(-1.0) ** i * np.linalg.det(below[..., columns != i]) for i in columns]
    return np.stack(cofactors, axis=1)


def _coefficients(values: FloatArray, unit: float) -> FloatArray:
    """Return the real coefficients, lowest power first, of a polynomial given on a circle."""
    scaled = (np.fft.fft(values) / len(values)).real
    scaled[abs(scaled) <= _NOTHING * abs(scaled).max()] = 0.0
    return np.asarray(scaled / unit ** np.arange(len(values)))
