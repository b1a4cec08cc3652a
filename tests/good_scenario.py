"""A scenario file that is right, to be spoilt, and values written as TOML."""

import json

GOOD = """
[plant]
inertia = "2 kg m^2"
[controller]
gains = "design"
[controller.specification]
crossover = "1 Hz"
phase_margin = "45 deg"
lower_gain_margin = "12 dB"
[feedforward]
error = "10 %"
[filter]
corner = "2 Hz"
order = 6
[limits.axis]
acceleration = "0.2 deg/s^2"
jerk = ["-1 deg/s^3", "2 deg/s^3"]
[[moves]]
name = "go"
distance = "60 arcsec"
limits = "axis"
settle_to = "50 mas"
"""
LINEAR = """
plant.inertia = "5 kg"
controller.gains = {kp = "3 N/mm", ki = "2 N/(m s)", kr = "0 N s/m"}
limits.axis = {velocity = "1 m/s", derivative_7 = "9 mm/s^7"}
moves = [{name = "go", distance = "-5 mm", settle_to = "1 um"}]
"""


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


MODES = """
[[modes]]
name = "tower"
frequency = "12 Hz"
damping = "2 %"
[[modes]]
name = "go"
frequency = "90 rpm"
"""


def inline(value: object) -> str:
    """Return a value as TOML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    if isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    return str(value)
