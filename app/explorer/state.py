"""What an explorer is about: a scenario's content as it is being changed, and measured data."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from ...analysis.measured import MeasuredResponse
from ...plant import PID, CascadedPI, ServoLoop
from ..overrides import override, parts_of
from ..scenario import Scenario, load_scenario, scenario_of
from ..scenario_loop import servo_loop_of
from ..text_files import read_toml
from .quantities import gain_units, said

Source = Literal["model", "data"]

_MOST_SAMPLES = 250  # of delay: states of the sampled loop


@dataclass(frozen=True, eq=False, kw_only=True)
class State:
    """A scenario's content and what the explorer adds to it.

    Parameters
    ----------
    path : Path
        Of the scenario file.
    content : dict
        As TOML has it, of format 2, the gains as numbers. Not to be changed: `put` copies it.
    measured : MeasuredResponse, optional
        Of the plant or of a loop.
    measured_name : str
        Of its file.
    source : "model" or "data"
        What margins are of.
    inertia_error, delay_error_s : float
        By how much the plant's inertia, as a fraction, and its delay may be off.
    move : int
        Number of the move that is shown.
    """

    path: Path
    content: dict[str, Any]
    measured: MeasuredResponse | None = None
    measured_name: str = ""
    source: Source = "model"
    inertia_error: float = 0.1
    delay_error_s: float = 0.0
    move: int = 0

    @cached_property
    def scenario(self) -> Scenario:
        """The content, checked, in SI units; ScenarioError for what it cannot mean."""
        return scenario_of(self.path, deepcopy(self.content))

    @cached_property
    def loop(self) -> ServoLoop:
        """The loop; ValueError where there is none."""
        return servo_loop_of(self.scenario)

    @property
    def data(self) -> MeasuredResponse | None:
        """What was measured, if margins are of that."""
        return self.measured if self.source == "data" else None

    @property
    def data_controller(self) -> Any:
        """The controller that closes the loop on what was measured; None of a loop."""
        needs = self.measured is not None and self.measured.kind in ("plant", "process-sensitivity")
        return self.loop.controller if needs else None


def opened(path: Path, *, measured: MeasuredResponse | None = None, name: str = "") -> State:
    """Return the state of a scenario file, its gains found where it asks for that.

    Raises
    ------
    ValueError
        For a file that cannot be used, a line for every problem.
    """
    load_scenario(path)  # with all that it says of a file
    return started(path, read_toml(path, "a scenario file (TOML)"), measured, name)


def started(
    path: Path, content: dict[str, Any], measured: MeasuredResponse | None = None, name: str = ""
) -> State:
    """Return the state of a scenario's content, which has to be one of a scenario."""
    own = scenario_of(path, deepcopy(content))  # with the messages of its own format
    state = State(
        path=path,
        content={"format": 2, **deepcopy(content)},
        measured=measured,
        measured_name=name,
        source="model" if measured is None else "data",
    )
    if not isinstance(own.gains, str):
        return in_time(state)
    return put(state, {"controller.gains": gains_of(state.loop.controller_noun.law, state)})


def put(state: State, values: Mapping[str, Any]) -> State:
    """Return the state with values in place of those at their keys, and checked.

    Parameters
    ----------
    state : State
    values : mapping of str to object
        Keys as in overrides of `load_scenario`, values as TOML has them; None takes a key away.

    Raises
    ------
    ValueError
        For keys and values that a scenario cannot have, and a loop that cannot be.
    """
    content = deepcopy(state.content)
    override(content, {key: value for key, value in values.items() if value is not None})
    for key in [key for key, value in values.items() if value is None]:
        _take(content, key)
    return with_content(state, content)


def with_content(state: State, content: dict[str, Any]) -> State:
    """Return the state with another content, checked."""
    changed = replace(state, content=content)
    changed.scenario  # noqa: B018 - checks it
    return in_time(changed)


def in_time(state: State) -> State:
    """Return a state whose delay is not so many samples that a page would wait for its numbers."""
    noun = state.loop.controller_noun
    if noun.sample_time is not None:
        samples = (noun.delay + state.delay_error_s) / noun.sample_time
        if samples > _MOST_SAMPLES:
            raise ValueError(
                f"a delay of {samples:.4g} samples, its error included: expected "
                f"{_MOST_SAMPLES} at most on this page; make it less, or see it by jounce survey"
            )
    return state


def gains_of(law: PID | CascadedPI, state: State) -> dict[str, Any]:
    """Return a law as a scenario's table of gains."""
    units = gain_units(state.scenario.motion)
    if isinstance(law, PID):
        return {name: said(getattr(law, name), units[name]) for name in ("kp", "ki", "kr")}
    raise TypeError(f"{law!r}: expected a PID")


def value_at(content: Mapping[str, Any], key: str) -> Any:
    """Return the value at a key as overrides have it; None where nothing stands."""
    here: Any = content
    for part in parts_of(key):
        if isinstance(here, list) and isinstance(part, int) and part < len(here):
            here = here[part]
        elif isinstance(here, Mapping):
            here = here.get(str(part))
        else:
            return None
    return here


def _take(content: dict[str, Any], key: str) -> None:
    """Take a key away."""
    *above, last = parts_of(key)
    here: Any = content
    for part in above:
        here = here[int(part)] if isinstance(here, list) else here.get(part, {})
    here.pop(last, None)
