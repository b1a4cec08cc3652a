"""An axis with a mode, to be swept, what of it varies, and figures that cost little."""

from jounce.app import Uniform

AXIS = """
format = 2
[plant]
inertia = "2 kg m^2"
[[plant.modes]]
name = "top"
frequency = "12 Hz"
damping = "2 %"
load_fraction = "30 %"
held = true
[controller]
gains = "design"
specification = { crossover = "2 Hz", phase_margin = "45 deg", lower_gain_margin = "12 dB" }
[limits.drive]
acceleration = "90 deg/s^2"
jerk = "900 deg/s^3"
[[moves]]
name = "quarter"
distance = "90 deg"
limits = "drive"
settle_to = "0.05 deg"
[requirements]
phase_margin = { min = "44 deg" }
"""
INERTIA = {"plant.inertia": Uniform("1.5 kg m^2", "2500 g m^2")}
QUICK = ("phase_margin", "crossover")
