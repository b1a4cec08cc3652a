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
# # Co-simulation: blocks out as FMUs, and FMUs in
#
# A Functional Mock-up Unit (FMU) is a block as a file: compiled C with a description, which any
# tool that knows FMI can run, without Python. Here a telescope's shaper, filter, controller and
# plant leave as FMUs, come back as if they were somebody else's, and close the same loop again.

# %%
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import control
import matplotlib.pyplot as plt
import numpy as np

from jounce.analysis import loop_margins
from jounce.app import survey_file
from jounce.fmu import (
    SampledController,
    cosimulate,
    export_fmu,
    export_ssp,
    inspect_fmu,
    linearize_fmu,
    load_fmu,
)

folders = [Path.cwd(), *Path.cwd().parents]
examples = next(f / "examples" for f in folders if (f / "examples").is_dir())
found = survey_file(examples / "telescope.toml")
loop, jerk_filter, move = found.loop, found.jerk_filter, found.moves[0]
dt, duration = 0.002, 4.0
arcsec = np.pi / 648000.0

# %% [markdown]
# ## Export
#
# The controller is sampled: once every `dt`, and its torque is held. Units go along; position is
# in rad, and the rest follows.

# %%
resources = ExitStack()
folder = Path(resources.enter_context(TemporaryDirectory()))
controller = SampledController(loop.controller, dt, loop.feedforward)
blocks = {
    "controller": controller,
    "plant": loop.plant,
    "filter": jerk_filter,
    "shaper": move.trajectory,
}
for name, block in blocks.items():
    made = export_fmu(block, folder / f"{name}.fmu", name=name, unit="rad", platforms=["host"])
    print(made.path.name, f"{made.path.stat().st_size / 1024:.0f} KiB", *made.platforms)

# %% [markdown]
# ## Inspect
#
# Reading a description runs nothing of the file. The same on the command line:
# `jounce fmu inspect controller.fmu`.

# %%
print(inspect_fmu(folder / "controller.fmu"))

# %% [markdown]
# ## Import, and close the loop
#
# `load_fmu` does run the file's native code: only for files that you trust. Blocks and connections
# are named, and the order in which the blocks step is explicit. Controller before plant, it is the
# sampled loop with a zero-order hold. The filter and the shaper come last, so that the controller
# sees the command of its own sample.

# %%
fmus = {name: resources.enter_context(load_fmu(folder / f"{name}.fmu")) for name in blocks}
connections = [
    ("shaper.position", "filter.command"),
    ("shaper.velocity", "filter.command_velocity"),
    ("shaper.acceleration", "filter.command_acceleration"),
    ("filter.position", "controller.r"),
    ("filter.velocity", "controller.r_rate"),
    ("filter.acceleration", "controller.r_acceleration"),
    ("plant.y", "controller.y"),
    ("plant.y_rate", "controller.y_rate"),
    ("controller.u", "plant.u"),
]
in_turn = cosimulate(fmus, connections, dt=dt, duration=duration)
print(in_turn)

# %% [markdown]
# A tool that steps all blocks at once, on what they showed at the step's start, adds a sample of
# delay to the loop:

# %%
for fmu in fmus.values():
    fmu.reset()
at_once = cosimulate(fmus, connections, dt=dt, duration=duration, order="jacobi")
print("\n".join(f"loop {text}: {extra} sample" for text, extra in at_once.loops.items()))

# %% [markdown]
# ## Beside the native survey
#
# The survey's response is exact, with a controller that is continuous in time. What differs is due
# to sampling: the error of a loop with perfect feedforward is zero there, and here what the held
# torque costs.

# %%
native = loop.respond(move.trajectory, dt, duration=duration, jerk_filter=jerk_filter)
runs = {"controller, then plant": in_turn, "all at once (one delay)": at_once}
figure, (position, difference) = plt.subplots(
    2, 1, sharex=True, figsize=(7, 6), layout="constrained"
)
position.plot(native.time, native.position / arcsec, "k", lw=3, alpha=0.3, label="native survey")
for (label, run), style in zip(runs.items(), ("-", "--"), strict=True):
    off = (run["plant.y"] - native.position) / arcsec
    position.plot(run.time, run["plant.y"] / arcsec, style, label=label)
    difference.plot(run.time, off, style, label=label)
    settled = np.flatnonzero(np.abs(run["plant.y"] / arcsec - 60.0) > 0.05)[-1] * dt
    print(
        f"{label}: at most {np.abs(off).max():.2g} arcsec from the survey, settled at "
        f"{settled:.3f} s (survey {move.configured.settling_time_s:.3f} s)"
    )
position.set(ylabel="position [arcsec]", title="60 arcsec, four FMUs in a loop")
difference.set(xlabel="time [s]", ylabel="FMUs − survey [arcsec]")
for ax in (position, difference):
    ax.legend()
    ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# The command is no cause of it. The filter takes the acceleration as constant within each step and
# so notices its jumps up to a step late; that costs far less.

# %%
apart = np.abs(in_turn["controller.r"][:-1] - native.command[:-1]).max() / arcsec
print(f"command: at most {apart:.2g} arcsec from the survey's")

# %% [markdown]
# ## An FMU as a python-control system
#
# `system()` makes an imported plant a block like any other of python-control. Behind the sampled
# controller it is exact, without a sample of delay.

# %%
fmus["plant"].reset()
plant = fmus["plant"].system(dt)
digital = loop.controller.sampled(dt)
forward = control.ss([], [], [], [[loop.feedforward.J_hat]], dt, inputs="r_acc", outputs="u_ff")
sums = [
    control.summing_junction(["r", "-y"], "e", name="error"),
    control.summing_junction(["r_rate", "-y_rate"], "e_rate", name="error_rate"),
    control.summing_junction(["u_feedback", "u_ff"], "u", name="torque"),
]


def closed(plant):
    """Return the loop around a plant."""
    inputs = ["r", "r_rate", "r_acc"]
    parts = [plant, digital, forward, *sums]
    return control.interconnect(parts, inputs=inputs, inplist=inputs, outputs="y", outlist="y")


time = native.time[:1001]
command = [in_turn[f"controller.{name}"][:1001] for name in ("r", "r_rate", "r_acceleration")]
imported = control.input_output_response(closed(plant), time, command).outputs
exact = control.forced_response(
    closed(control.ss(control.c2d(loop.plant.system(), dt), name="plant")), time, command
).outputs
print(f"imported plant: {np.abs(imported - exact).max() / arcsec:.1g} arcsec from the exact loop")
print(f"cosimulate:     {np.abs(in_turn['plant.y'][:1001] - exact).max() / arcsec:.1g} arcsec")

# %% [markdown]
# ## Margins of a loop around somebody else's plant
#
# An FMU has no transfer function. `linearize_fmu` finds one, from directional derivatives or from
# impulse responses with rollback; then `loop_margins` works on it.

# %%
fmus["plant"].reset()
candidates = {
    "continuous": loop.loop_transfer(),
    "sampled": loop.sampled_loop_transfer(dt),
    "derivatives": digital * linearize_fmu(fmus["plant"], dt),
    "impulses": digital * linearize_fmu(fmus["plant"], dt, method="impulse"),
}
for name, transfer in candidates.items():
    margins = loop_margins(transfer)
    print(
        f"{name:12s} crossover {margins.crossover_hz:.9f} Hz, phase margin "
        f"{margins.phase_margin_deg:.7f}°, lower gain margin {margins.lower_gain_margin_db:.7f} dB"
    )

# %% [markdown]
# ## The whole loop in one file
#
# System Structure and Parameterization (SSP) packs components and connections together; on the
# command line `jounce fmu export telescope.toml --block loop --move "60 arcsec step"`.

# %%
made = export_ssp(
    folder / "telescope.ssp",
    move.trajectory,
    loop,
    dt=dt,
    jerk_filter=jerk_filter,
    unit="rad",
    platforms=["host"],
)
print(made.path.name, f"{made.path.stat().st_size / 1024:.0f} KiB:", ", ".join(made.components))
resources.close()
