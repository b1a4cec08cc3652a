"""Loops and moves of a notebook as the content of a scenario, which the explorer changes."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite, nextafter
from typing import Any, Literal

import numpy as np

from ...analysis.specification import Move
from ...plant import PID, Axis, BackCalculation, CascadedPI, Clamp, ServoLoop
from ...plant.discretise import filter_system_of
from ...shaping.derivatives import DERIVATIVE_NAMES
from .quantities import gain_units, said

Unit = Literal["rad", "m"]
Content = dict[str, Any]

_MOTION: Mapping[str, Literal["angle", "length"]] = {"rad": "angle", "m": "length"}
_TORQUE = {"rad": "N m", "m": "N"}
_INERTIA = {"rad": ("inertia", "kg m^2"), "m": ("mass", "kg")}
_ROUNDING = 1e-13
_STILL = {"name": "at rest", "rate": "0", "duration": "1 s"}  # a scenario asks for something


def content_of(what: ServoLoop | Move, unit: Unit) -> Content:
    """Return the content of a scenario for a loop, or for a move of an inertia of 1.

    Parameters
    ----------
    what : ServoLoop or Move
        Numbers in N m and rad, or in N and m, and s.
    unit : "rad" or "m"
        What positions are in.

    Raises
    ------
    TypeError, ValueError
        For what is neither, or what a scenario file cannot say.
    """
    if unit not in _MOTION:
        raise ValueError(f"unit = {unit!r}: expected 'rad' or 'm', what positions are in")
    if isinstance(what, ServoLoop):
        return {
            "format": 2,
            "title": "loop",
            "position_unit": unit,
            "plant": _plant(what.axis, unit),
            "controller": _controller(what, unit),
            "feedforward": _feedforward(what, unit),
            "tracking": [{**_STILL, "rate": f"0 {unit}/s"}],
        }
    if isinstance(what, Move):
        return _of_move(what, unit)
    raise TypeError(
        f"{type(what).__name__}: expected a ServoLoop, an analysis.Move, a scenario or its path"
    )


def _of_move(move: Move, unit: Unit) -> Content:
    noun, of_inertia = _INERTIA[unit]
    if move.shapers:
        raise ValueError("a move with input shapers: give it without, and choose one on the page")
    asked = {
        "name": move.name,
        "distance": said(move.distance, unit),
        "settle_to": said(move.settle_to, unit),
        "limits": move.limits_name,
    }
    timing = {"duration": move.duration, "round_to": move.round_to}
    asked |= {name: said(value, "s") for name, value in timing.items() if value is not None}
    design = {"crossover": "1 Hz", "phase_margin": "45 deg", "lower_gain_margin": "12 dB"}
    return {
        "format": 2,
        "title": move.name,
        "position_unit": unit,
        "plant": {noun: f"1 {of_inertia}"},
        "controller": {"gains": "design", "specification": design},
        "limits": {move.limits_name: _limits(move, unit)},
        "moves": [asked],
    }


def _limits(move: Move, unit: Unit) -> Content:
    found: Content = {}
    for k, bound in enumerate(move.bounds, start=1):
        name = DERIVATIVE_NAMES[k] if k < len(DERIVATIVE_NAMES) else f"derivative_{k}"
        per = f"{unit}/s" if k == 1 else f"{unit}/s^{k}"
        if isinstance(bound, tuple):
            found[name] = [said(side, per) for side in bound]
        elif isfinite(bound):
            found[name] = said(bound, per)
    return found


def _plant(axis: Axis, unit: Unit) -> Content:
    torque, noun = _TORQUE[unit], _INERTIA[unit]
    values = {
        "viscous": (axis.viscous, f"{torque} s/{unit}"),
        "load_viscous": (axis.load_viscous, f"{torque} s/{unit}"),
        "spring": (axis.spring, f"{torque}/{unit}"),
        "constant_load": (axis.constant_load, torque),
        "current_lag": (axis.current_lag, "s"),
        "encoder_step": (axis.encoder_step, unit),
    }
    plant: Content = {name: said(*value) for name, value in values.items() if value[0]}
    if axis.torque_limit < inf:
        plant["torque_limit" if unit == "rad" else "force_limit"] = said(axis.torque_limit, torque)
    if axis.sensor != "motor":
        plant["sensor"] = axis.sensor
    if axis.friction is not None:
        both = {"coulomb": axis.friction.coulomb, "static": axis.friction.holds}
        plant["friction"] = {name: said(value, torque) for name, value in both.items()}
    if axis.ripple is not None:
        raise ValueError("an axis with ripple: write a scenario file, and explore that")
    return {**_body(axis, unit, noun), **plant}


def _body(axis: Axis, unit: Unit, noun: tuple[str, str]) -> Content:
    """Return what moves: masses in a row, a transfer function, or an inertia with modes."""
    torque = _TORQUE[unit]
    chain, system = axis.body, getattr(axis.body, "system", None)
    if hasattr(chain, "masses"):
        return {
            "chain": {
                "masses": [said(mass, noun[1]) for mass in chain.masses],
                "springs": [said(spring, f"{torque}/{unit}") for spring in chain.springs],
                "dampers": [said(damper, f"{torque} s/{unit}") for damper in chain.dampers],
            }
        }
    if system is not None:
        import control

        return {"transfer": _transfer(control.tf(system))}
    modes = [_mode(mode) for mode in axis.modes]
    return {noun[0]: said(axis.J, noun[1]), **({"modes": modes} if modes else {})}


def _transfer(transfer: Any) -> Content:
    """Return coefficients, without leading ones that are rounding."""
    above, below = transfer.num_array[0, 0], transfer.den_array[0, 0]
    first = int(np.argmax(abs(above) > _ROUNDING * abs(above).max()))
    return {"numerator": above[first:].tolist(), "denominator": below.tolist()}


def _percent(share: float) -> str:
    """Return a share in percent, so that it is read as it is: 0.7 is not 0.01 × 70."""
    near = 100.0 * share
    around = (near, nextafter(near, 0.0), nextafter(near, inf))
    return said(next((each for each in around if 0.01 * each == share), near), "%")


def _mode(mode: Any) -> Content:
    told: Content = {"frequency": said(mode.frequency_hz, "Hz")}
    told["damping"] = _percent(mode.damping)
    if mode.load_fraction is None:
        return told | {"motor_shape": mode.motor_shape, "load_shape": mode.load_shape}
    return told | {"load_fraction": _percent(mode.load_fraction), "held": mode.held}


def _controller(loop: ServoLoop, unit: Unit) -> Content:
    noun = loop.controller_noun
    law: Any = noun.law
    told: Content = {"gains": _gains(law, unit)}
    if isinstance(law, PID) and law.derivative_filter:
        told["derivative_filter"] = said(law.derivative_filter, "s")
    if noun.sample_time is not None:
        told["sample_time"] = said(noun.sample_time, "s")
        told["delay"] = said(noun.delay, "s")
        told["discretisation"] = noun.discretisation
    if noun.anti_windup is not None:
        told["anti_windup"] = _anti_windup(noun.anti_windup, unit)
    if noun.filters:
        told["filters"] = [_filter(element) for element in noun.filters]
    return told


def _gains(law: PID | CascadedPI, unit: Unit) -> Content:
    if isinstance(law, PID):
        units = gain_units(_MOTION[unit])
        return {name: said(getattr(law, name), units[name]) for name in units}
    told: Content = {
        "kind": "p-pi",
        "position_gain": said(law.position_gain, "s^-1"),
        "velocity_gain": said(law.velocity_gain, f"{_TORQUE[unit]} s/{unit}"),
        "velocity_feedforward": law.velocity_feedforward,
    }
    times = {"reset_time": law.reset_time, "velocity_filter": law.velocity_filter}
    return told | {name: said(time, "s") for name, time in times.items() if 0.0 < time < inf}


def _anti_windup(way: Any, unit: Unit) -> Any:
    if isinstance(way, BackCalculation):
        return {"kind": "back-calculation", "tracking_time": said(way.tracking_time, "s")}
    if isinstance(way, Clamp):
        return {"kind": "clamp", "integral_limit": said(way.integral_limit, _TORQUE[unit])}
    return way


def _filter(element: Any) -> Content:
    kind = type(element).__name__
    if kind == "Notch":
        return {
            "kind": "notch",
            "frequency": said(element.zero_hz, "Hz"),
            "pole_frequency": said(element.pole_hz, "Hz"),
            "zero_damping": _percent(element.zero_damping),
            "pole_damping": _percent(element.pole_damping),
        }
    if kind == "LeadLag":
        places = {"zero": element.zero_hz, "pole": element.pole_hz}
        return {"kind": "lead-lag", **{name: said(hz, "Hz") for name, hz in places.items()}}
    if kind == "LowPass":
        told = {"kind": "low-pass", "corner": said(element.corner_hz, "Hz"), "order": element.order}
        return told | ({"damping": _percent(element.damping)} if element.order == 2 else {})
    import control

    return {"kind": "transfer", **_transfer(control.tf(filter_system_of(element)))}


def _feedforward(loop: ServoLoop, unit: Unit) -> Content:
    noun, torque = loop.feedforward_noun, _TORQUE[unit]
    if noun.position or any(not 1 <= k <= 4 for k in noun.torque):
        raise ValueError(
            "a feedforward of position, or of a derivative above snap: write a scenario file with "
            "feedforward.inverse, and explore that"
        )
    told: Content = {}
    for k in (1, 2, 3, 4):
        per = "s" if k == 1 else f"s^{k}"
        gain = noun.torque.get(k, 0.0)
        if gain or k == 2:
            told[DERIVATIVE_NAMES[k]] = said(gain, f"{torque} {per}/{unit}")
    times = {"lead": (noun.lead, "s"), "friction": (noun.friction, torque)}
    return told | {name: said(*value) for name, value in times.items() if value[0]}
