"""What the columns of a file are by their names, and the response that they make together."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from .rational_fits import Complex, Real

FREQUENCY_UNITS: dict[str, float] = {
    "Hz": 1.0,
    "kHz": 1e3,
    "mHz": 1e-3,
    "MHz": 1e6,
    "rad/s": 1.0 / (2.0 * np.pi),
    "rpm": 1.0 / 60.0,
}
"""Hz of each unit of frequency."""

_ROUNDED = 1e-3  # of a coherence above 1 by rounding

Column = tuple[str, Any]
"""A column's name and its values."""

_ROLES: tuple[tuple[str, str], ...] = (
    ("response", r"^response$"),
    ("coherence", r"coh|gamma|γ"),
    ("sigma", r"sigma|σ|std|stdev|uncert"),
    ("power", r"psd|power|spectr"),
    ("phase", r"phase|phas|arg|angle|phi|φ|winkel|∠|^deg$|^degrees$|^rad$|^°$"),
    ("frequency", r"freq|omega|ω|frequenz|^[fw]\b|^hz$|^khz$|^rad/s$|^f_?(hz|khz)$|^w_?rad"),
    ("re", r"^re$|real|^re[\W_]|[\W_]re$"),
    ("im", r"^im$|imag|^im[\W_]|[\W_]im$"),
    ("gain", r"mag|gain|abs|ampl|^amp|db|betrag|^\|"),
)
_UNITS = (
    ("rad/s", r"rad[\s/_.]*s|omega|ω|^w$"),
    ("kHz", r"khz"),
    ("mHz", r"(?-i:mHz)"),
    ("MHz", r"(?-i:MHz)"),
    ("rpm", r"rpm"),
    ("Hz", r"hz"),
    ("dB", r"db"),
    ("deg", r"deg|°|º|grad"),
    ("rad", r"rad"),
    ("abs", r"abs|lin|ratio"),
)


def role_of(name: str) -> str:
    """Return what a column is by its name, "" where that is not known."""
    word = name.strip().lower()
    bare = re.sub(r"[\[(][^\])]*[\])]", "", word).strip() or word
    for role, pattern in _ROLES:
        if re.search(pattern, bare):
            return role
    return next((role for role, pattern in _ROLES if re.search(pattern, word)), "")


def unit_of(name: str) -> str:
    """Return the unit that a column's name has in it, "" for none."""
    word = name.strip()
    return next((unit for unit, pattern in _UNITS if re.search(pattern, word, re.I)), "")


def by_role(where: str, columns: list[Column]) -> dict[str, Column]:
    """Return the columns by what they are.

    Raises
    ------
    ValueError
        Where two are the same, or one that is needed is not there.
    """
    found: dict[str, Column] = {}
    for name, values in columns:
        role = role_of(name)
        if role in found and role not in ("", "power"):
            raise ValueError(
                f"{where}: columns {found[role][0]!r} and {name!r} are both {role}: expected one; "
                "give columns=… with a name for each, '-' for those to leave out"
            )
        found.setdefault(role, (name, values))
    _check(where, found, [name for name, _ in columns])
    return found


def _check(where: str, found: Mapping[str, Column], names: list[str]) -> None:
    told = ", ".join(map(repr, names))
    if "frequency" not in found:
        raise ValueError(
            f"{where}: no column of {told} is a frequency: expected a name such as 'frequency_hz'; "
            "give columns=('frequency Hz', …)"
        )
    if not ({"re", "im"} <= set(found) or {"gain", "phase"} <= set(found) or "response" in found):
        if "power" in found:
            raise ValueError(
                f"{where}: {found['power'][0]!r} is a power spectrum, without phase: expected a "
                "frequency response, re and im or gain and phase; measure excitation and output"
            )
        raise ValueError(
            f"{where}: columns {told} hold no complex response: expected re and im, or gain and "
            "phase; give columns=… with a name for each, such as 'dB' and 'deg'"
        )


def hertz(where: str, column: Column, unit: str | None) -> Real:
    """Return frequencies in Hz by the unit in the column's name, or the one given, or as Hz."""
    name, values = column
    own = unit_of(name)
    own = own if own in FREQUENCY_UNITS else ""
    if unit is not None and own and unit != own:
        raise ValueError(
            f"{where}: frequency_unit = {unit!r}, but column {name!r} is in {own}: expected one of "
            "them; leave frequency_unit out, or name the column in columns=…"
        )
    return np.asarray(values, dtype=float) * FREQUENCY_UNITS[unit or own or "Hz"]


def complex_response(where: str, found: Mapping[str, Column]) -> Complex:
    """Return the response of re and im, or of gain and phase."""
    if "response" in found:
        return np.asarray(found["response"][1], dtype=complex)
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is told by its line
        if {"re", "im"} <= set(found):
            return np.asarray(found["re"][1] + 1j * np.asarray(found["im"][1]))
        phase = _radians(where, *found["phase"])
        return np.asarray(_gain(where, *found["gain"]) * np.exp(1j * phase))


def _gain(where: str, name: str, values: Real) -> Real:
    negative = values < 0.0
    if unit_of(name) == "abs" and negative.any():
        raise ValueError(
            f"{where}: column {name!r} has {values[negative][0]:g} in it: expected magnitudes, 0 "
            "or more; give columns=… with 'dB' in its place if they are decibels"
        )
    decibels = unit_of(name) == "dB" or negative.any()
    return np.asarray(10.0 ** (values / 20.0) if decibels else values)


def _radians(where: str, name: str, values: Real) -> Real:
    unit = unit_of(name)
    if unit in ("deg", "rad"):
        return np.asarray(np.radians(values) if unit == "deg" else values)
    if np.nanmax(abs(values)) > 4.0 * np.pi:
        return np.asarray(np.radians(values))
    raise ValueError(
        f"{where}: column {name!r} names no unit and its values fit both degrees and rad: expected "
        "'phase_deg' or 'phase_rad'; give columns=… with 'deg' or 'rad' in its place"
    )


def deviations(
    where: str, found: Mapping[str, Column], response: Complex, averages: int | None
) -> Real | None:
    """Return σ as it was measured, or of the coherence γ² of n averages: |G|·√((1 − γ²)/(γ²·n))."""
    if "sigma" in found:
        return np.asarray(found["sigma"][1], dtype=float)
    if "coherence" not in found or averages is None:
        return None
    name, given = found["coherence"]
    square = np.asarray(given, dtype=float)
    bad = ~((square >= 0.0) & (square <= 1.0 + _ROUNDED))
    if bad.any():
        raise ValueError(
            f"{where}: column {name!r} has {square[bad][0]:g} in it: expected coherences from 0 to "
            "1; divide percentages by 100, or leave the line out"
        )
    square = np.clip(square, 1e-6, 1.0)
    return np.asarray(abs(response) * np.sqrt((1.0 - square) / (square * averages)))
