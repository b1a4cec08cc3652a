"""The keys of a scenario file, and the words for a key or table that is not right."""

import difflib
import json
import re
import tomllib
from collections.abc import Iterator, Sequence
from typing import Any

from .units import show

Place = tuple[str | int, ...]
"""Where a value stands in a file: ("moves", 0, "settle_to")."""

EXAMPLE = tomllib.loads("""
title = "Telescope axis"
position_unit = "arcsec"
plant.inertia = "1 kg m^2"
feedforward = {inertia = "1 kg m^2", error = "10 %"}
filter = {corner = "2 Hz", order = 6}
limits.axis.acceleration = "0.2 deg/s^2"
[controller]
specification = {crossover = "1 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
gains = {kp = "3 N m/rad", ki = "2 N m/(rad s)", kr = "5 N m s/rad"}
[[modes]]
name = "tower"
frequency = "12 Hz"
damping = "2 %"
[[moves]]
name = "60 arcsec step"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
""")
"""Every key once: what is known, and what to write where something is missing."""

EXAMPLE_2 = {
    **EXAMPLE,
    **tomllib.loads("""
format = 2
[plant]
inertia = "1 kg m^2"
mass = "1 kg"
viscous = "0.1 N m s/rad"
load_viscous = "0.1 N m s/rad"
spring = "1 N m/rad"
torque_limit = "10 N m"
force_limit = "10 N"
current_limit = "5 A"
torque_constant = "0.5 N m/A"
force_constant = "0.5 N/A"
gear_ratio = 10.0
current_lag = "0.5 ms"
encoder_step = "0.1 arcsec"
encoder_counts = 1048576
sensor = "motor"
constant_load = "1 N m"
friction = {coulomb = "0.3 N m", static = "0.4 N m"}
ripple = {period = "1 deg", amplitude = "0.1 N m", positions = ["0 deg"], torques = ["0 N m"]}
frf.file = "axis.csv"
frf.kind = "plant"
frf.output = "position"
frf.columns = ["Hz", "dB", "deg"]
frf.frequency_unit = "Hz"
frf.averages = 20
frf.integrators = 2
frf.unstable_poles = 0
chain = {masses = ["1 kg"], springs = ["1 N/m"], dampers = ["0.1 N s/m"]}
[plant.transfer]
numerator = [1.0]
denominator = [1.0, 0.0, 0.0]
zeros = [-1.0]
poles = [0.0, 0.0, [-2.0, 5.0]]
gain = 1.0
a = [[0.0, 1.0], [0.0, -0.5]]
b = [0.0, 1.0]
c = [1.0, 0.0]
d = 0.0
[[plant.modes]]
name = "tower"
frequency = "6 Hz"
damping = "1 %"
held = true
load_fraction = "50 %"
motor_shape = 1.0
load_shape = -1.0
[controller]
gains.pid = {kind = "pid", kp = "3 N m/rad", ki = "2 N m/(rad s)", kr = "5 N m s/rad"}
specification = {crossover = "1 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB"}
derivative_filter = "5 ms"
sample_time = "1 ms"
delay = "1.5 samples"
anti_windup.back-calculation = {kind = "back-calculation", tracking_time = "0.1 s"}
anti_windup.clamp = {kind = "clamp", integral_limit = "2 N m"}
discretisation = "tustin"
tune = {max_sensitivity = 1.6, max_complementary = 1.6}
[controller.gains.p-pi]
kind = "p-pi"
position_gain = "20 s^-1"
velocity_gain = "5 N m s/rad"
reset_time = "50 ms"
velocity_filter = "1 ms"
velocity_feedforward = 1.0
[[controller.filters]]
lead-lag = {kind = "lead-lag", zero = "1 Hz", pole = "10 Hz"}
low-pass = {kind = "low-pass", corner = "200 Hz", order = 2, damping = "70 %"}
[controller.filters.transfer]
kind = "transfer"
numerator = [1.0]
denominator = [0.01, 1.0]
zeros = [-1.0]
poles = [-9.0]
gain = 9.0
a = [[-9.0]]
b = [1.0]
c = [9.0]
d = 0.0
[controller.filters.notch]
kind = "notch"
frequency = "8 Hz"
pole_frequency = "9 Hz"
zero_damping = "5 %"
pole_damping = "50 %"
[feedforward]
inertia = "1 kg m^2"
error = "10 %"
velocity = "0.1 N m s/rad"
acceleration = "1 kg m^2"
jerk = "0.01 N m s^3/rad"
snap = "0.001 N m s^4/rad"
friction = "0.3 N m"
inverse = true
lead = "auto"
[shaper]
kind = "ZV"
modes = ["tower"]
frequency = "6 Hz"
damping = "1 %"
vibration = "5 %"
[[moves]]
name = "60 arcsec step"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
shaper = {kind = "ZV", modes = ["tower"], frequency = "6 Hz", damping = "1 %", vibration = "5 %"}
duration = "2 s"
round_to = "1 ms"
minimum_jerk = true
[moves.disturbances]
torque_step = {torque = "1 N m", force = "1 N", time = "0 s", on = "motor"}
torque_sine = {amplitude = "1 N m", frequency = "2 Hz", on = "motor"}
encoder_noise = "10 mas"
seed = 1
[moves.disturbances.torque_file]
path = "torque.csv"
unit = "N m"
time = "0"
torque = "1"
force = "1"
on = "load"
[moves.disturbances.torque_spectrum]
frequencies = ["0.1 Hz", "10 Hz"]
densities = ["2 N^2 m^2/Hz", "0.1 N^2 m^2/Hz"]
path = "wind.csv"
unit = "N^2 m^2/Hz"
frequency = "0"
density = "1"
on = "load"
[moves.disturbances.encoder_spectrum]
frequencies = ["1 Hz", "500 Hz"]
densities = ["4 mas^2/Hz", "0.1 mas^2/Hz"]
path = "encoder.csv"
unit = "mas^2/Hz"
frequency = "0"
density = "1"
[moves.disturbances.wind]
kind = "von_karman"
sigma = "1 N m"
corner = "0.5 Hz"
length = "80 m"
speed = "8 m/s"
on = "load"
[[tracking]]
name = "stars"
rate = "sidereal"
duration = "10 s"
after = "5 s"
sine = {amplitude = "1 arcsec", frequency = "1 Hz"}
onto = {distance = "3 deg", limits = "axis"}
scan = {length = "1 deg", rate = "0.1 deg/s", lines = 2, limits = "axis"}
[tracking.file]
path = "command.csv"
unit = "deg"
time = "0"
position = "1"
sample_time = "1 ms"
limits = "axis"
[disturbances]
torque_step = {torque = "1 N m", force = "1 N", time = "0 s", on = "motor"}
encoder_noise = "10 mas"
[disturbances.torque_sine]
name = "pump"
amplitude = "1 N m"
frequency = "2 Hz"
duration = "10 s"
after = "5 s"
on = "motor"
[disturbances.torque_file]
name = "storm"
path = "torque.csv"
unit = "N m"
time = "0"
torque = "1"
force = "1"
duration = "10 s"
after = "5 s"
on = "load"
[disturbances.torque_spectrum]
frequencies = ["0.1 Hz", "10 Hz"]
densities = ["2 N^2 m^2/Hz", "0.1 N^2 m^2/Hz"]
path = "wind.csv"
unit = "N^2 m^2/Hz"
frequency = "0"
density = "1"
on = "load"
[disturbances.encoder_spectrum]
frequencies = ["1 Hz", "500 Hz"]
densities = ["4 mas^2/Hz", "0.1 mas^2/Hz"]
path = "encoder.csv"
unit = "mas^2/Hz"
frequency = "0"
density = "1"
[disturbances.wind]
kind = "von_karman"
sigma = "1 N m"
corner = "0.5 Hz"
length = "80 m"
speed = "8 m/s"
on = "load"
[requirements]
load_settling = {max = "2 s"}
"""),
}
EXAMPLE_2["plant"]["ripple"]["forces"] = ["0 N"]
EXAMPLE_2["believed"] = EXAMPLE_2["plant"]
for _acting in (EXAMPLE_2["disturbances"], EXAMPLE_2["moves"][0]["disturbances"]):
    for _key in ("step", "sine", "file", "spectrum"):
        _acting[f"force_{_key}"] = _acting[f"torque_{_key}"]
EXAMPLE_2["tracking"][0]["disturbances"] = EXAMPLE_2["moves"][0]["disturbances"]
"""The same of format 2; tables of several kinds stand under the names of the kinds."""

EXAMPLES = {1: EXAMPLE, 2: EXAMPLE_2}
_TAGGED = ("gains", "filters", "anti_windup")
"""Keys behind which pydantic names the kind of table that it took."""


class PlaceError(ValueError):
    """A value further inside than pydantic knows is not right."""

    def __init__(self, place: tuple[str, ...], message: str) -> None:
        super().__init__(message)
        self.place = place


def problem_line(error: Any, number: int = 1) -> str:
    """Return one of pydantic's findings on a file of format 1 or 2 in our own words."""
    where, kind, value = error["loc"], error["type"], error["input"]
    section, example = tuple(part for part in where if isinstance(part, str)), EXAMPLES[number]
    if kind == "value_error":
        found = error["ctx"]["error"]
        where, problem = (*where, *getattr(found, "place", ())), str(found)
    elif kind == "missing":
        problem = f"is missing; write {what_to_write(*section, example=example)}"
    elif kind in ("extra_forbidden", "unexpected_keyword_argument"):
        known = (*_known(section[:-1], example)[1], *["format"] * (section[:-1] == ()))
        problem = unknown_key(section[-1], value, tuple(dict.fromkeys(known)))
    elif kind in ("union_tag_invalid", "union_tag_not_found", "literal_error"):
        where, problem = _wrong_kind(where, kind, error)
    else:
        shown = "is empty" if value == {} else f"{show(value)} is not a table"
        problem = f"{shown}; write {what_to_write(*section, example=example)}"
    return f"{key_path(_without_kinds(where) if number == 2 else where)}: {problem}"


def lines_of(problems: Sequence[Any], number: int) -> Iterator[tuple[Any, str]]:
    """Yield each problem and its line; keys of format 2 in a file of format 1 share one."""
    newer = [each for each in problems if number == 1 and _is_of_2(each)]
    if newer:
        more = f" and {len(newer) - 1} more" if len(newer) > 1 else ""
        yield (
            newer[0],
            f"{key_path(newer[0]['loc'])}{more}: of format 2; write format = 2 at the top of the "
            "file",
        )
    yield from ((each, problem_line(each, number)) for each in problems if each not in newer)


def _is_of_2(error: Any) -> bool:
    section = tuple(part for part in error["loc"] if isinstance(part, str))
    unknown = error["type"] in ("extra_forbidden", "unexpected_keyword_argument")
    return unknown and section[-1] in _known(section[:-1], EXAMPLE_2)[1]


def _wrong_kind(where: Place, kind: str, error: Any) -> tuple[Place, str]:
    """Return the place of a kind that is not known, and what to say of it."""
    if kind == "literal_error":
        return where, f"{show(error['input'])} is not known; write {error['ctx']['expected']}"
    place = (*where, "kind")
    if kind == "union_tag_not_found":
        return place, "is missing; write " + " or ".join(f'kind = "{k}"' for k in _kinds(where))
    tag, expected = error["ctx"]["tag"], error["ctx"]["expected_tags"]
    return place, f"{show(tag)} is not known; write one of {expected}"


def _kinds(where: Place) -> list[str]:
    return list(_known([part for part in where if isinstance(part, str)], EXAMPLE_2)[1])


def _without_kinds(where: Place) -> Place:
    """Return a key's path without the kinds of tables."""
    if where[:1] != ("controller",) or len(where) < 3 or where[1] not in _TAGGED:
        return where
    at = 3 if isinstance(where[2], int) else 2
    kinds = _known(("controller", str(where[1])), EXAMPLE_2)[1]
    return (*where[:at], *where[at + (where[at : at + 1] != () and where[at] in kinds) :])


def unknown_key(
    key: str, value: object, known: Sequence[str], *, shown: Sequence[str] | None = None
) -> str:
    """Return what to say of a key that is not among the known ones."""
    near = difflib.get_close_matches(key, known, n=1)
    remedy = f"did you mean {near[0]}?" if near else "remove it"
    return f"unknown key (with {show(value)}); accepted: {', '.join(shown or known)}; {remedy}"


def key_path(where: Sequence[str | int]) -> str:
    """Return a key as TOML writes it: ``moves."60 arcsec step".duration_s``."""
    text = ""
    for part in where:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += "." + (part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else _quoted(part))
    return text.removeprefix(".")


def _quoted(key: str) -> str:
    return json.dumps(key, ensure_ascii=not key.isprintable())


def _known(where: Sequence[str], example: dict[str, Any]) -> tuple[str, Any]:
    """Return an example's path and value; any name of a set of limits leads to the example's."""
    path, value = [], example
    for key in where:
        path.append(key if key in value else next(iter(value)))
        value = value[path[-1]]
        value = value[0] if isinstance(value, list) else value
    return ".".join(path), value


def what_to_write(*where: str, example: dict[str, Any] | None = None) -> str:
    """Return what to write for a key, in a file of format 1 if it has the key."""
    if example is None:
        example = EXAMPLE if where[0] in EXAMPLE else EXAMPLE_2
    path, value = _known(where, example)
    if not isinstance(value, dict):
        return f"{where[-1]} = {json.dumps(value)}"
    key, first = next(iter(value.items()))
    if isinstance(first, dict) and not isinstance(first.get("kind"), str):
        return what_to_write(*where, key, example=example)
    if isinstance(first, dict):
        return f"a table of one of the kinds {', '.join(value)}"
    header = f"[[{path}]]" if isinstance(_listed(where, example), list) else f"[{path}]"
    return f"{header} with {', '.join(value)}"


def _listed(where: Sequence[str], example: dict[str, Any]) -> Any:
    """Return what stands at a key, a list as a list."""
    value = _known(where[:-1], example)[1]
    return value.get(where[-1]) if isinstance(value, dict) else None
