"""Gains that are found under stated bounds: shown first, then taken or not."""

from __future__ import annotations

from typing import Any

from ...analysis.tuning import tune_pid
from ...plant import PID
from .loop_view import margins_of
from .quantities import DIGITS, gain_units, said
from .state import State, put


def proposed(state: State, max_sensitivity: float, max_complementary: float) -> State:
    """Return the state with the PID of largest integral gain under bounds on |S| and |T|.

    Found on the data, if margins are of a measured plant; with the filters that there are.

    Raises
    ------
    ValueError
        For a P-PI, and where no gains keep the bounds.
    """
    noun = state.loop.controller_noun
    if not isinstance(noun.law, PID):
        raise ValueError("gains are found for a PID, and this scenario has a P-PI cascade")
    on_data = state.data is not None and state.data.kind == "plant"
    found = tune_pid(
        state.data if on_data else state.loop.plant,
        max_sensitivity=max_sensitivity,
        max_complementary=max_complementary,
        derivative_filter=noun.law.derivative_filter,
        filters=noun.filters,
        sample_time=noun.sample_time,
        delay=0.0 if on_data else noun.delay,
    ).pid
    units = gain_units(state.scenario.motion)
    gains = {
        f"controller.gains.{name}": said(float(f"{getattr(found, name):.{DIGITS}g}"), unit)
        for name, unit in units.items()
    }
    return put(state, {"controller.gains": {}, **gains})


def proposal_part(state: State, proposal: State) -> dict[str, Any]:
    """Return what a proposal changes: gains and margins before and after."""
    names = ("kp", "ki", "kr")
    before, after = (each.content["controller"]["gains"] for each in (state, proposal))
    margins = [margins_of(each) for each in (state, proposal)]
    shown = ("crossover_hz", "phase_margin_deg", "sensitivity_peak", "complementary_peak")
    return {
        "part": "proposal",
        "gains": [[name, before.get(name, ""), after[name]] for name in names],
        "margins": [[name, *(getattr(each, name) for each in margins)] for name in shown],
    }
