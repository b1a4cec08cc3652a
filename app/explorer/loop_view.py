"""What is shown of a loop: margins, curves, elements, handles, each a part of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor, isfinite, log10
from typing import Any

import numpy as np

from ...analysis.margins import loop_margins
from ...analysis.measured import MeasuredResponse, closed_responses, open_loop
from ...shaping.pieces import FloatArray
from .fields import element_fields
from .handles import Handle, handles_of
from .margin_circles import circles
from .open_loops import OpenGain, open_gain
from .state import State
from .verdicts import Margins, Revision, bound_of, judged

Part = dict[str, Any]

_BAND = float(np.sqrt(-np.log(0.05)))
_SMALL = 1e-15


@dataclass(frozen=True, eq=False)
class LoopView:
    """A state's loop: its margins, and what else is shown, worked out when it is asked for.

    Attributes
    ----------
    state : State
    margins : LoopMargins or MeasuredMargins
        Of what the state takes for its source.
    """

    state: State
    margins: Margins

    @cached_property
    def gain(self) -> OpenGain:
        """L of the model."""
        return open_gain(self.state.loop)

    @cached_property
    def handles(self) -> list[Handle]:
        """The handles of the controller's elements."""
        return handles_of(self.state, _place(self.state, self.margins))

    @cached_property
    def window(self) -> tuple[float, float]:
        """The frequencies in Hz from and to which is drawn."""
        return _window(self)

    @cached_property
    def curve(self) -> tuple[FloatArray, Any]:
        """Frequencies, and L of the model there."""
        places = [handle.frequency_hz for handle in self.handles]
        return self.gain.curve(*self.window, places)

    @cached_property
    def data(self) -> MeasuredResponse | None:
        """L as it was measured, or of what was measured with the controller; None without data."""
        state = self.state
        return None if state.measured is None else open_loop(state.measured, state.data_controller)


def loop_view(state: State) -> LoopView:
    """Return the view of a state."""
    return LoopView(state, margins_of(state))


def margins_of(state: State) -> Margins:
    """Return the margins of a state's loop, or of its data."""
    if state.data is None:
        return loop_margins(state.loop)
    return loop_margins(state.data, controller=state.data_controller)


def numbers_part(view: LoopView, revision: Revision) -> Part:
    """Return the margins with their verdicts."""
    margins = view.margins
    return {
        "part": "numbers",
        "stable": margins.stable,
        "notes": [*getattr(margins, "reasons", ()), *getattr(margins, "warnings", ())],
        "margins": judged(margins, revision),
        "revision": revision.name,
        "source": view.state.source,
        "data": view.state.measured_name,
    }


def curves_part(view: LoopView, revision: Revision) -> Part:
    """Return L of the model, and of the data with bars, the elements and their handles."""
    frequency, value = view.curve
    part: Part = {
        "part": "curves",
        "range_hz": [*view.window],
        "model": _curve(frequency, value),
        "handles": [_handle(view, handle) for handle in view.handles],
        "elements": element_fields(view.state),
        "circles": circles(view.margins, revision),
        "crossovers_hz": list(view.margins.crossovers_hz),
        "phase_margin_deg": view.margins.phase_margin_deg,
    }
    if view.data is not None:
        part["data"] = _curve(view.data.frequency_hz, view.data.response) | _bars(view.data)
        part["data"]["phase_deg"] = _phase_beside(part["model"], view.data)
    return part


def closed_part(view: LoopView, revision: Revision) -> Part:
    """Return |S| and |T| with their limits."""
    frequency, value = view.curve
    part: Part = {
        "part": "closed",
        "range_hz": [*view.window],
        "frequency": frequency,
        "s_db": decibel(1.0 / (1.0 + value)),
        "t_db": decibel(value / (1.0 + value)),
        "limits_db": {
            letter: _limit_db(bound_of(revision, name)[1])
            for letter, name in (("S", "sensitivity_peak"), ("T", "complementary_peak"))
        },
    }
    if view.data is not None:
        both = closed_responses(view.data)
        part["data"] = {"frequency": both.frequency_hz}
        for letter, name in (("s", "sensitivity"), ("t", "complementary")):
            small, large = both.band(name)
            part["data"] |= {
                f"{letter}_db": decibel(getattr(both, name)),
                f"{letter}_low": decibel(small),
                f"{letter}_high": decibel(large),
            }
    return part


def decibel(value: Any) -> FloatArray:
    """Return magnitudes in dB, −300 where they vanish."""
    return np.asarray(20.0 * np.log10(np.maximum(abs(np.asarray(value)), _SMALL)))


def _curve(frequency: FloatArray, value: Any) -> Part:
    return {
        "frequency": frequency,
        "gain_db": decibel(value),
        "phase_deg": np.degrees(np.unwrap(np.angle(value))) + _turns(value),
        "re": np.clip(value.real, -1e6, 1e6),
        "im": np.clip(value.imag, -1e6, 1e6),
    }


def _phase_beside(model: Part, loop: MeasuredResponse) -> FloatArray:
    """Return the phase of data in degrees, in the turn that is nearest to the model's."""
    near = np.interp(loop.frequency_hz, model["frequency"], model["phase_deg"])
    off = np.degrees(np.angle(loop.response)) - near
    return np.asarray(near + (off + 180.0) % 360.0 - 180.0)


def _turns(value: Any) -> float:
    """Return the whole turns that bring a phase to start between −360 and 0 degrees."""
    start = float(np.degrees(np.angle(value[0])))
    return -360.0 if start > 1.0 else 0.0


def _bars(loop: MeasuredResponse) -> Part:
    if loop.sigma is None:
        return {}
    size, reach = abs(loop.response), _BAND * loop.sigma
    return {
        "low_db": decibel(np.maximum(size - reach, 0.05 * size)),
        "high_db": decibel(size + reach),
        "radius": reach,
    }


def _handle(view: LoopView, handle: Handle) -> Part:
    """Return a handle where it is put: on the curve that is looked at."""
    size = view.gain.size([handle.frequency_hz])[0]
    if view.data is not None and view.state.source == "data":
        at, lines = np.log(handle.frequency_hz), np.log(view.data.frequency_hz)
        size = np.exp(np.interp(at, lines, np.log(abs(view.data.response))))
    return {
        "name": handle.name,
        "label": handle.label,
        "hz": handle.frequency_hz,
        "db": float(decibel(size)),
        "across": bool(handle.across) or handle.name == "gain",
        "along": bool(handle.along),
        "wide": bool(handle.wide),
    }


def _place(state: State, margins: Margins) -> float:
    """Return the crossover, or where one might be."""
    if isfinite(margins.crossover_hz):
        return margins.crossover_hz
    if margins.crossovers_hz:
        return margins.crossovers_hz[0]
    asked = state.scenario.specification
    return 1.0 if asked is None else asked.crossover_hz


def _window(view: LoopView) -> tuple[float, float]:
    """Return the frequencies that are drawn, in halves of a decade so that they keep still."""
    places = [handle.frequency_hz for handle in view.handles]
    places += [mode.frequency for mode in view.state.scenario.plant.modes]
    low, high = min(places) / 10.0, max(places) * 10.0
    low, high = 10.0 ** (floor(2 * log10(low)) / 2), 10.0 ** (-floor(-2 * log10(high)) / 2)
    sample = view.state.loop.controller_noun.sample_time
    if sample is not None:
        high = min(high, 0.5 / sample)
    if view.data is not None:
        lines = view.data.frequency_hz
        low, high = min(low, float(lines[0])), max(high, float(lines[-1]))
    return low, high if sample is None else min(high, 0.5 / sample)


def _limit_db(most: float) -> float | None:
    return float(decibel(most)) if isfinite(most) else None
