"""Filters run once a sample: Tustin's with prewarping, matched poles and zeros, or a hold."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, tan
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import rounded_down, shown
from ..shaping.warned import warn_caller
from .exact_response import state_space
from .filters import Filter, LeadLag, LowPass, Notch

if TYPE_CHECKING:
    import control

Discretisation = Literal["tustin", "matched", "hold"]
Element = Filter | Any
"""A filter, or any python-control system with one input and one output."""


_FAITHFUL: dict[Discretisation, float] = {"tustin": 0.8, "matched": 1.0, "hold": 0.1}
"""Share of the Nyquist frequency to which a sampled notch is about what was asked for."""


class FilterWarning(UserWarning):
    """A filter is so near to the Nyquist frequency that its sampled form is another one."""


def checked_filters(
    filters: Any, dt: float | None, discretisation: Discretisation
) -> tuple[Element, ...]:
    """Return the filters behind one another; for a sample time dt, none at or above Nyquist.

    One so near to it that its sampled form is another filter is warned of.
    """
    given = (filters,) if not isinstance(filters, Sequence) else tuple(filters)
    for element in given:
        if not isinstance(element, Notch | LeadLag | LowPass):
            _check_system(element, dt)
        elif dt is not None:
            _check_below_nyquist(element, dt)
            _warn_near_nyquist(element, dt, discretisation)
    return given


def _check_below_nyquist(element: Filter, dt: float) -> None:
    highest = element.prewarp_hz
    if isinstance(element, Notch):
        highest = max(element.zero_hz, element.pole_hz or 0.0)
    if 2.0 * highest * dt >= 1.0:
        raise ValueError(
            f"{element!r} at or above the Nyquist frequency of {0.5 / dt:g} Hz: use a sample time "
            f"below {rounded_down(0.5 / highest)}, or leave the filter out"
        )


def _warn_near_nyquist(element: Filter, dt: float, discretisation: Discretisation) -> None:
    hz, notch = element.prewarp_hz, isinstance(element, Notch)
    share = 2.0 * hz * dt
    if share <= _FAITHFUL[discretisation if notch else "tustin"]:
        return
    held = notch and discretisation == "hold"
    does = "passes what it should stop" if held else "is much narrower" if notch else "is distorted"
    other = f"discretisation = {'matched' if share > _FAITHFUL['tustin'] else 'tustin'!r}, or "
    warn_caller(
        f"{type(element).__name__} at {hz:g} Hz, {share:.2g} of the Nyquist frequency of "
        f"{0.5 / dt:g} Hz: the sampled one {does}; use {other if notch else ''}"
        f"a sample time up to {rounded_down(0.5 * _FAITHFUL['tustin'] / hz)}",
        FilterWarning,
    )


def _check_system(element: Any, dt: float | None) -> None:
    import control

    if not isinstance(element, control.StateSpace | control.TransferFunction):
        raise TypeError(
            f"filters: {shown(element)}: expected Notch, LeadLag, LowPass or a python-control "
            "system"
        )
    if element.ninputs != 1 or element.noutputs != 1:
        raise ValueError(
            f"filters: a system with {element.ninputs} inputs and {element.noutputs} outputs: "
            "expected one of each"
        )
    if element.isdtime(strict=True) and (dt is None or element.dt not in (True, dt)):
        raise ValueError(
            f"filters: a system sampled every {element.dt!r} in a controller with sample_time = "
            f"{dt!r}: give it continuous, or with the controller's sample time"
        )


def filter_system_of(element: Element) -> control.StateSpace:
    """Return a filter as a state space, as it is given."""
    if isinstance(element, Notch | LeadLag | LowPass):
        return state_space(element.transfer())
    return state_space(element)


def sections(filters: Sequence[Element], dt: float, discretisation: Discretisation) -> FloatArray:
    """Return the filters as sections (b0, b1, b2, a1, a2) run once a sample, (m, 5).

    y_k = b0·x_k + b1·x_{k−1} + b2·x_{k−2} − a1·y_{k−1} − a2·y_{k−2}
    """
    rows: list[FloatArray] = []
    for element in filters:
        if discretisation == "tustin" and isinstance(element, Notch | LeadLag | LowPass):
            rows.append(_tustin(element, dt))
        else:
            rows.extend(_general(element, dt, discretisation))
    return np.array(rows).reshape(-1, 5)


def _tustin(element: Filter, dt: float) -> FloatArray:
    """Return s → c·(z − 1)/(z + 1) with c = ω/tan(ω·T/2) at the frequency that is kept."""
    omega = 2.0 * pi * element.prewarp_hz
    c = omega / tan(0.5 * omega * dt)
    above, below = element.polynomials()
    if len(below) == 2:
        first, second = ([0.0, *x][-2:] for x in (above, below))
        (n1, n0), (d1, d0) = first, second
        whole = d1 * c + d0
        return np.array([n1 * c + n0, n0 - n1 * c, 0.0, d0 - d1 * c, 0.0]) / whole
    (n2, n1, n0), (d2, d1, d0) = ([0.0, 0.0, *x][-3:] for x in (above, below))
    whole = d2 * c * c + d1 * c + d0
    return (
        np.array(
            [
                n2 * c * c + n1 * c + n0,
                2.0 * (n0 - n2 * c * c),
                n2 * c * c - n1 * c + n0,
                2.0 * (d0 - d2 * c * c),
                d2 * c * c - d1 * c + d0,
            ]
        )
        / whole
    )


def _general(element: Element, dt: float, discretisation: Discretisation) -> list[FloatArray]:
    """Return sections of any system, from its zeros and poles.

    scipy puts zeros at 0 where some are missing, each of which is a sample too early.
    """
    from scipy.signal import cont2discrete, zpk2sos

    system = filter_system_of(element)
    if system.isdtime(strict=True):
        zeros, poles, gain = _zpk(system)
    elif discretisation == "matched":
        zeros, poles, gain = _matched(system, dt)
    else:
        method = "zoh" if discretisation == "hold" else "bilinear"
        matrices = (system.A, system.B, system.C, system.D)
        *held, _ = cont2discrete(matrices, dt, method)
        import control

        zeros, poles, gain = _zpk(control.ss(*held, dt))
    rows = np.asarray(zpk2sos(zeros, poles, gain))
    delays = [np.array([0.0, 1.0, 0.0, 0.0, 0.0])] * (len(poles) - len(zeros))
    return [np.array([*row[:3], *row[4:]]) / row[3] for row in rows] + delays


def _zpk(system: control.StateSpace) -> tuple[Any, Any, float]:
    """Return zeros, poles and gain, found where the system is neither 0 nor infinite."""
    zeros, poles = np.asarray(system.zeros()), np.asarray(system.poles())
    zeros = zeros[np.isfinite(zeros)]
    at = 2.0 + 0.0 * abs(np.concatenate([zeros, poles])).max(initial=1.0)
    value = complex(system(at))
    return zeros, poles, float((value * np.prod(at - poles) / np.prod(at - zeros)).real)


def _matched(system: control.StateSpace, dt: float) -> tuple[Any, Any, float]:
    """Return z = e^(sT) of zeros and poles, the missing zeros at −1, the gain at DC."""
    zeros, poles = np.asarray(system.zeros()), np.asarray(system.poles())
    zeros = zeros[np.isfinite(zeros)]
    missing = len(poles) - len(zeros)
    after = np.append(np.exp(zeros * dt), -np.ones(missing))
    at_poles = np.exp(poles * dt)
    still = complex(system(0.0))
    gain = still * np.prod(1.0 - at_poles) / np.prod(1.0 - after)
    if not np.isfinite(gain) or gain == 0.0:
        raise ValueError(
            "discretisation = 'matched' needs filters that pass a constant: use 'tustin' for an "
            "integrator or a filter with a zero at 0"
        )
    return after, at_poles, float(gain.real)
