"""The key `frf` of a scenario's plant: a measured response in the place of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, ConfigDict

from ..analysis.measured.column_roles import FREQUENCY_UNITS
from ..analysis.measured.measured_response import KINDS
from ..analysis.requirement_checks import OF_MARGINS
from .scenario_checks import NAME, whole
from .scenario_keys import Key, choice
from .units import show

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic_core import CoreSchema

TIME_RESPONSE = (
    "a measured response has no time response; fit an axis to it with analysis.fit_axis and write "
    "inertia and modes that it finds into [plant]"
)
"""Why something cannot be done with a measured plant, and what to do."""

_RUNNING = ("moves", "tracking", "disturbances", "feedforward", "filter", "shaper", "modes")
_INSIDE = ("filters", "derivative_filter", "anti_windup", "tune")
_OF_THE_PLANT = ("plant", "process-sensitivity")
_COUNT = choice(*range(7))


def _read_columns(value: object) -> tuple[str, ...]:
    names = value if isinstance(value, list) else ()
    if not names or not all(isinstance(name, str) for name in names):
        raise ValueError(
            f'{show(value)} is not a list of names; write one such as ["Hz", "dB", "deg", "-"]'
        )
    return tuple(map(str, names))


_COLUMNS = Key(_read_columns, {"type": "array", "items": {"type": "string"}, "minItems": 1})


@dataclass(frozen=True, kw_only=True)
class FrfSection:
    """A measured response in a file beside the scenario, as `read_frf` takes it."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")
    file: Annotated[str, NAME]
    kind: Annotated[str, choice(*KINDS)] = "plant"
    output: Annotated[
        Literal["position", "velocity", "acceleration"],
        choice("position", "velocity", "acceleration"),
    ] = "position"
    columns: Annotated[tuple[str, ...] | None, _COLUMNS] = None
    frequency_unit: Annotated[str | None, choice(*FREQUENCY_UNITS)] = None
    averages: Annotated[int | None, whole(10**9, "averages = 20")] = None
    integrators: Annotated[int | None, _COUNT] = None
    unstable_poles: Annotated[int | None, _COUNT] = None

    @property
    def has_controller(self) -> bool:
        """Whether the controller is in what was measured."""
        return self.kind not in _OF_THE_PLANT


class _OrPath:
    """A key that takes the name of a file, or else a table with it."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return pydantic's own form of the check."""
        return BeforeValidator(_as_table).__get_pydantic_core_schema__(source, handler)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return what an editor is told."""
        return {"anyOf": [{"type": "string", "examples": ["axis.csv"]}, handler(core)]}


def _as_table(value: object) -> object:
    if not isinstance(value, str | dict):
        raise ValueError(
            f'{show(value)} is no file of a measured response; write frf = "axis.csv", or '
            'frf = { file = "axis.csv", averages = 20 }'
        )
    return {"file": value} if isinstance(value, str) else value


OR_PATH = _OrPath()
"""The check of the key itself."""


def check_measured(checked: Any) -> None:
    """Refuse what cannot stand beside a measured plant, or only there.

    Raises
    ------
    ValueError
        One line that begins with the key.
    """
    frf, controller = checked.plant.frf, checked.controller
    if frf is None:
        if controller.gains == "measured":
            raise ValueError(
                "controller.gains: 'measured' without a measured loop; write frf into [plant], "
                'or gains = "design"'
            )
        return
    usual = type(checked).model_fields
    running = [key for key in _RUNNING if getattr(checked, key) != usual[key].default]
    if running:
        raise ValueError(f"{running[0]}: {TIME_RESPONSE}, or leave {', '.join(running)} out")
    for asked in checked.requirements:
        if asked.name not in OF_MARGINS:
            raise ValueError(
                f"requirements.{asked.name}: {TIME_RESPONSE}, or require margins alone: "
                f"{', '.join(OF_MARGINS)}"
            )
    _check_controller(frf, controller)


def _check_controller(frf: FrfSection, controller: Any) -> None:
    if frf.has_controller:
        inside = [key for key in _INSIDE if getattr(controller, key) not in (0.0, (), None, "none")]
        if controller.gains != "measured" or inside:
            raise ValueError(
                f"controller.{[*inside, 'gains'][0]}: plant.frf of kind {frf.kind!r} has its "
                'controller in it; write gains = "measured" and leave the rest out, or measure '
                "the plant"
            )
    elif controller.gains in ("measured", "design", "published"):
        raise ValueError(
            f"controller.gains: {controller.gains!r} with a measured plant: expected its own, as "
            'there is no model; write gains = "tune", or a table { kp, ki, kr }'
        )
    elif controller.gains == "tune" and frf.kind != "plant":
        raise ValueError(
            f"controller.gains: 'tune' with plant.frf of kind {frf.kind!r}, which was measured "
            "with gains; write those, or make the plant's response by analysis.plant_response"
        )
    if controller.delay:
        raise ValueError(
            f"controller.delay: {controller.delay:g} s beside plant.frf, which has its delay in "
            "it; leave it out"
        )
