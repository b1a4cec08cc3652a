"""Circles around −1 that margins are, in the Nyquist and in the Nichols plane."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

import numpy as np

from ...shaping.pieces import FloatArray
from .verdicts import Margins, Revision, bound_of

_TURN = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 181))


def circles(margins: Margins, revision: Revision) -> list[dict[str, Any]]:
    """Return where |S|, |T| and the disk margin are what they are at most, or may be.

    |S| = M: L = e^(jθ)/M − 1,    |T| = M: L = M·e^(jθ)/(1 − M·e^(jθ)),
    disk α: L = (α/2·e^(jθ) − 1)/(α/2·e^(jθ) + 1)
    """
    found = []
    for name, letter in (("sensitivity_peak", "S"), ("complementary_peak", "T")):
        peak, most = getattr(margins, name), bound_of(revision, name)[1]
        for size, kind in ((peak, "peak"), (most, "limit")):
            if isfinite(size) and size > 1.0:
                found.append(
                    _circle(f"|{letter}| = {size:.3g}", letter, kind, _at_peak(letter, size))
                )
    disk = margins.disk_margin
    if 0.0 < disk < inf:
        half = 0.5 * disk * _TURN
        found.append(
            _circle(f"disk margin {disk:.3g}", "disk", "peak", (half - 1.0) / (half + 1.0))
        )
    return found


def _at_peak(letter: str, size: float) -> Any:
    return _TURN / size - 1.0 if letter == "S" else size * _TURN / (1.0 - size * _TURN)


def _circle(label: str, letter: str, kind: str, value: Any) -> dict[str, Any]:
    return {
        "label": label,
        "of": letter,
        "kind": kind,
        "re": np.clip(value.real, -1e6, 1e6),
        "im": np.clip(value.imag, -1e6, 1e6),
        "phase_deg": _within_a_turn(value),
        "gain_db": np.asarray(20.0 * np.log10(np.maximum(abs(value), 1e-15))),
    }


def _within_a_turn(value: Any) -> FloatArray:
    """Return phases between −360 and 0 degrees."""
    return np.asarray(-(np.degrees(-np.angle(value)) % 360.0))
