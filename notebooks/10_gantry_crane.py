# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A gantry crane: a load that does not swing
#
# A container hangs on a rope of 2.8 m and swings at 0.3 Hz, as good as undamped. Nobody measures
# the swing: the drive knows the trolley's position alone, holds it stiffly, and whatever the
# trolley's motion leaves swinging swings for minutes. 5 t, three fifths of them the load, are
# taken over 12 m at 1 m/s, 0.4 m/s² and 2 m/s³.
#
# | required | |
# | --- | --- |
# | load settled to 20 mm | in 20 s |
# | with a rope 10 % longer or shorter | in 20 s |
# | force | 6000 N |

# %%
from math import pi, sqrt

import matplotlib.pyplot as plt

from jounce.analysis import loop_margins, residual_vibration, sensitivity_of_shapers
from jounce.plant import Axis, CascadedPI, Controller, Feedforward, FlexibleMode, ServoLoop
from jounce.shaping import Limits, input_shaper, min_time_move


def crane(rope=2.8):
    """Return the trolley with its load on a rope of some length in m."""
    pendulum = FlexibleMode(sqrt(9.81 / rope) / (2 * pi), 0.005, load_fraction=0.6, held=True)
    return Axis(5000.0, modes=[pendulum], viscous=800.0, torque_limit=6000.0)


swing_hz = crane().modes[0].frequency_hz
print(f"{swing_hz:.3f} Hz with the trolley held, {swing_hz / sqrt(0.4):.3f} Hz with it free")

# %% [markdown]
# ## The loop
#
# The drive's cascade at 100 Hz: a P controller of position over a PI controller of velocity.
# Stiff, so that the load's pull does not move the trolley, and the load swings as with the
# trolley held.

# %%
cascade = CascadedPI(position_gain=2.0, velocity_gain=40e3, reset_time=2.0)
controller = Controller(cascade, sample_time=0.01, delay=0.01)
feedforward = Feedforward({"velocity": 800.0, "acceleration": 5000.0})
margins = loop_margins(ServoLoop(crane(), controller))
print(margins)

# %% [markdown]
# ## First try: the S-curve

# %%
distance, tolerance = 12.0, 0.02
limits = Limits(velocity=1.0, acceleration=0.4, jerk=2.0)
s_curve = min_time_move(distance, limits)


def driven(command, rope=2.8):
    """Return the response, and when the load has settled, in s."""
    loop = ServoLoop(crane(rope), controller, feedforward)
    response = loop.respond(command, dt=0.01, duration=120.0)
    return response, response.settling_time(distance, tolerance, of="load")


first, settled_first = driven(s_curve)
swings = residual_vibration(s_curve, swing_hz)
print(f"command {s_curve.duration:.2f} s, load settled {settled_first:.1f} s")
print(f"the command alone leaves {swings * 1e3:.0f} mm swinging, the loop", end=" ")
print(f"{abs(first.load_error[first.time > s_curve.duration]).max() * 1e3:.0f} mm")

# %% [markdown]
# The trolley stops, the container goes on. Slower limits help by luck only, where a swing happens
# to end with a ramp. What always helps is to start the move in two parts, half a swing apart: the
# second takes back what the first one set swinging.
#
# ## Remedy: an input shaper
#
# ZV is that, exactly, with the damping in it, for 1.7 s more; ZVD takes three parts, and forgives
# a wrong frequency, to the first order.

# %%
shapers = {kind: input_shaper(kind, swing_hz, 0.005) for kind in ("ZV", "ZVD", "EI")}
commands = {"S-curve": s_curve, **{kind: s.shape(s_curve) for kind, s in shapers.items()}}
found = {name: driven(command) for name, command in commands.items()}
for name, (response, settled) in found.items():
    left = residual_vibration(commands[name], swing_hz, 0.005) * 1e3
    peak = abs(response.torque).max()
    print(
        f"{name:8s} command {commands[name].duration:6.2f} s, alone leaves {left:7.2f} mm, "
        f"load settled {settled:6.2f} s, force up to {peak:.0f} N"
    )

# %%
# %matplotlib inline
figure, (swing, force) = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained")
for name in ("S-curve", "ZV"):
    response, settled = found[name]
    shown = response.time < 40.0
    time = response.time[shown]
    swing.plot(time, response.twist[shown] * 1e3, label=f"{name}: settled {settled:.1f} s")
    force.plot(time, response.torque[shown], label=name, lw=1)
swing.axhspan(-20.0, 20.0, color="C2", alpha=0.25, label="±20 mm")
swing.set(xlabel="time [s]", ylabel="load − trolley [mm]", title="Swing")
force.axhline(6000.0, color="C3", linestyle="--", label="limit")
force.axhline(-6000.0, color="C3", linestyle="--")
force.set(xlabel="time [s]", ylabel="force [N]", title="Force")
for ax in (swing, force):
    ax.legend(loc="upper right")
    ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ZV's command nulls the swing of a trolley that is where it should be. The loop is stiff, not
# rigid: what is left of the swing, 15 mm, is the trolley giving way to the load.
#
# ## The rope has another length
#
# Nobody enters the rope's length to the centimetre. What the shapers leave of a step, over the
# frequency's ratio to that expected, tells which one to take:

# %%
curves = sensitivity_of_shapers(shapers, swing_hz, 0.005)
for name, width in zip(curves.names, curves.insensitivity(0.05), strict=True):
    print(f"{name}: less than 5 % left within ±{50.0 * width:.0f} % of the frequency")
_ = curves.plot()
plt.show()

# %%
print("rope [m]  " + "".join(f"{name:>9s}" for name in commands) + "   settled [s]")
settling = {}
for rope in (2.52, 2.66, 2.8, 2.94, 3.08):
    settling[rope] = {name: driven(command, rope)[1] for name, command in commands.items()}
    print(f"{rope:8.2f}  " + "".join(f"{settled:9.2f}" for settled in settling[rope].values()))

# %% [markdown]
# ## Required and achieved

# %%
worst = {name: max(at[name] for at in settling.values()) for name in commands}
figures = {
    "first try settled [s]": settled_first,
    "ZV settled [s]": found["ZV"][1],
    "ZV, rope ±10 %, settled [s]": worst["ZV"],
    "ZVD, rope ±10 %, settled [s]": worst["ZVD"],
    "peak force [N]": abs(found["ZVD"][0].torque).max(),
    "phase margin [deg]": margins.phase_margin_deg,
}
for name, figure in figures.items():
    print(f"{name:30s} {figure:8.2f}")

# %% [markdown]
# ZVD is the one to take. In a file the crane is `examples/gantry_crane.toml`, surveyed by `jounce
# survey`. Its shaped move leaves as an FMU, `jounce fmu export examples/gantry_crane.toml --block
# trajectory --move "to the ship"`, the whole crane with `--block servo`, either as C for the
# crane's control with `jounce export c`.
