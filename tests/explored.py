"""A scenario that the explorer is tried on, and what a session shows of it."""

from pathlib import Path

from jounce.app.explorer.session import Session
from jounce.app.explorer.state import opened

EXAMPLES = Path(__file__).parent.parent / "examples"

SCENARIO = """\
# Two modes and a notch.
format = 2
title = "Two modes"
position_unit = "mrad"

[plant]
inertia = "2 kg m^2" # what the motor turns
viscous = "3 N m s/rad"
torque_limit = "300 N m"

# The first mode is the one that the notch is for.
[[plant.modes]]
name = "first"
frequency = "61 Hz"
damping = "0.6 %"
motor_shape = 0.5
load_shape = -0.5

[[plant.modes]]
name = "second"
frequency = "140 Hz" # measured
damping = "1 %"
motor_shape = 0.3
load_shape = 0.3

[controller]
gains = { kp = "2000 N m/rad", ki = "2e4 N m/(rad s)", kr = "60 N m s/rad" } # by hand
derivative_filter = "1 ms"
sample_time = "0.25 ms"
delay = "1 sample"

# Where the first mode rings.
[[controller.filters]]
kind = "notch"
frequency = "72 Hz" # of the free one
zero_damping = "5 %"
pole_damping = "50 %"

# What the turn may be.
[limits.axis]
velocity = "1 rad/s"
acceleration = "20 rad/s^2"
jerk = "1000 rad/s^3"

# The one move.
[[moves]]
name = "turn"
distance = "100 mrad"
settle_to = "0.05 mrad"

[requirements]
sensitivity_peak = { max = 2.0 }
"""
NOTCH = "controller.filters[0]"


def written(folder: Path, text: str = SCENARIO) -> Path:
    """Write the scenario; return its file."""
    path = folder / "two_modes.toml"
    path.write_text(text, encoding="utf-8")
    return path


def session_of(path: Path, **options) -> Session:
    """Return a session of a file as it stands."""
    return Session(opened(path, **options), path.read_text(encoding="utf-8"))


def told(session: Session, *messages, until: str = "ready") -> dict[str, dict]:
    """Give a session messages; return its parts by name, up to one."""
    for message in messages:
        session.receive(message)
    found = {}
    for part in session.parts():
        found[part["part"]] = part
        if part["part"] == until:
            break
    return found


def problem_of(session: Session, message: dict) -> str:
    """Give a session a message; return what it says is wrong, without what it goes on to show."""
    return told(session, message, until="problem")["problem"]["text"]


def value_of(parts: dict[str, dict], name: str) -> float:
    """Return a margin that is shown."""
    [row] = [row for row in parts["numbers"]["margins"] if row["name"] == name]
    return row["value"]
