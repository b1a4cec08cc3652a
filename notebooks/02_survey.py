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
# # The survey of a servo loop
#
# A rigid axis under a PID controller with feedforward of the commanded acceleration, after
# Section VII of P. M. Thompson's "Snap, Crackle, and Pop".

# %%
import control
import matplotlib.pyplot as plt
import numpy as np

from jounce.analysis import loop_margins
from jounce.plant import Inertia, InertiaFeedforward, ServoLoop, design_pid
from jounce.plant.pid import printed_pid
from jounce.shaping import JerkFilter, Limits, min_time_move

plant = Inertia(1.0)
gains = design_pid(plant, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
loop = ServoLoop(plant, gains, InertiaFeedforward(J_hat=1.0))
print(gains)
print(loop_margins(loop.loop_transfer()))

# %% [markdown]
# The loop is conditionally stable: it has a *lower* gain margin and no upper one. The transfer
# functions are python-control's own, so its tools work on them.

# %%
frequency = np.logspace(-1, 1, 300)
response = loop.loop_transfer()(2j * np.pi * frequency)
figure, (gain, phase) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
gain.semilogx(frequency, 20 * np.log10(np.abs(response)))
gain.set_ylabel("|L| [dB]")
phase.semilogx(frequency, np.degrees(np.unwrap(np.angle(response))) - 360)
phase.set(xlabel="frequency [Hz]", ylabel="phase of L [deg]")
for ax in (gain, phase):
    ax.grid(alpha=0.3, which="both")
figure.suptitle("Open loop L = g·k")
plt.show()

# %% [markdown]
# ## What the printed gains do
#
# The paper prints k_r = 11.09 J, k_i = 6.286 k_r, k_p = 3.187 k_r for the same specifications.
# They do not meet them.

# %%
for label, pid in (("designed", gains), ("printed", printed_pid(plant))):
    candidate = ServoLoop(plant, pid)
    margins = loop_margins(candidate.loop_transfer())
    step = control.step_response(candidate.closed_loop(), np.linspace(0, 6, 6001))
    print(
        f"{label}: {margins.crossover_hz:.3f} Hz, {margins.phase_margin_deg:.1f}°, "
        f"{margins.lower_gain_margin_db:.1f} dB, "
        f"overshoot {100 * (step.outputs.max() - 1):.1f} %"
    )

# %% [markdown]
# ## A shaped move through the loop
#
# 60 arcsec at 0.2 deg/s², behind a jerk filter. With feedforward the axis follows the filtered
# command exactly; without it, the loop overshoots; a wrong Ĵ lies between.

# %%
move = min_time_move(60.0, Limits(acceleration=0.2 * 3600.0))  # arcsec, s
jerk_filter = JerkFilter(corner_hz=2.0, order=6)
figure, (position, error) = plt.subplots(2, 1, sharex=True, figsize=(7, 6), layout="constrained")
for j_hat, label in ((0.0, "no feedforward"), (1.1, "Ĵ 10 % too large"), (1.0, "Ĵ = J")):
    shaped = ServoLoop(plant, gains, InertiaFeedforward(j_hat)).respond(
        move, dt=0.002, duration=4.0, jerk_filter=jerk_filter
    )
    settled = shaped.settling_time(target=60.0, tolerance=0.05)
    position.plot(shaped.time, shaped.position, label=f"{label}, settles at {settled:.2f} s")
    error.plot(shaped.time, shaped.error, label=label)
position.plot(shaped.time, move(shaped.time), "k:", label="acceleration-limited command")
position.set(ylabel="position [arcsec]", title="60 arcsec, settled to 50 mas")
error.set(xlabel="time [s]", ylabel="tracking error [arcsec]")
for ax in (position, error):
    ax.legend()
    ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## The whole survey from a scenario file
#
# `jounce survey examples/telescope.toml --output out/telescope` does all of this at once, and
# writes numbers, responses and the picture. From Python:

# %%
from pathlib import Path

from jounce.app import survey_file

folders = [Path.cwd(), *Path.cwd().parents]
examples = next(f / "examples" for f in folders if (f / "examples").is_dir())
found = survey_file(examples / "telescope.toml")
print(found.margins)
for shaped in found.moves:
    settled = shaped.configured.settling_time_s
    print(f"{shaped.name}: {shaped.duration_s:.4f} s, settled {settled:.4f} s")
_ = found.plot()
