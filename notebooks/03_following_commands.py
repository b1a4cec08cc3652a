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
# # Following commands
#
# Targets change while the axis moves, ramps have to be tracked, axes have to arrive together. All
# of it is the same question, asked again and again: from this state of motion, what is the fastest
# way to that one?

# %%
import matplotlib.pyplot as plt
import numpy as np

from jounce.plots import plot_following, plot_motions, plot_phase_plane
from jounce.shaping import (
    CommandFollower,
    InfeasibleError,
    JerkFilter,
    Limits,
    min_time_transfer,
    min_time_transfers,
    s_curve_move,
    synchronize,
    velocity_transfer,
)

limits = Limits(velocity=2.0, acceleration=1.0, jerk=4.0)  # deg, s

# %% [markdown]
# ## From any state to any other
#
# `min_time_transfer` takes position, velocity and acceleration at both ends. What cannot be reached
# is refused, with the nearest that can; a start outside its bounds is brought inside first.

# %%
crossing = min_time_transfer((0.0, 1.0, 0.5), (3.0, -0.5), limits)
print(crossing, f"violation {crossing.violation(limits):.1e}")

too_fast = min_time_transfer((0.0, 3.0), 5.0, limits)
print(too_fast)

try:
    min_time_transfer(0.0, (1.0, 2.0, -1.0), limits)
except InfeasibleError as error:
    print(error)

spin_up = velocity_transfer(0.0, 1.5, limits)
print(f"to 1.5 deg/s in {spin_up.duration:.4f} s, over {spin_up.end_state[0]:.4f} deg")

# %% [markdown]
# Many problems at once cost little more than one:

# %%
rng = np.random.default_rng(3)
starts = np.column_stack([np.zeros(10_000), rng.uniform(-1.5, 1.5, 10_000)])
batch = min_time_transfers(starts, [5.0], limits)
print(f"10,000 transfers, {batch.duration.min():.3f} to {batch.duration.max():.3f} s")

# %% [markdown]
# ## Retargeting in mid-slew
#
# A follower is asked for one sample at a time. Here the target changes twice while the axis moves;
# velocity and acceleration keep their bounds, whatever is commanded (Thompson, Figure 2c).

# %%
follower = CommandFollower(Limits(velocity=2.0, acceleration=1.0), dt=0.01)
time = np.arange(0.0, 16.0, 0.01)
commands = np.select([time < 3.0, time < 6.5], [8.0, 2.0], default=7.0)
response = follower.run(commands)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
plot_following(response, ax=left, unit="deg").legend(loc="lower right")
plot_phase_plane(response, ax=right, unit="deg").legend(loc="lower left")
for bound in (-2.0, 2.0):
    right.axhline(bound, color="0.4", linewidth=0.8, linestyle=":")
figure.suptitle("Two changes of mind in mid-slew")
plt.show()

# %% [markdown]
# With a bound on jerk, and with a jerk filter behind the follower, the same commands:

# %%
smooth = CommandFollower(limits, dt=0.01).run(commands)
filtered = CommandFollower(
    Limits(velocity=2.0, acceleration=1.0), dt=0.01, jerk_filter=JerkFilter(2.0, 6)
).run(commands)

figure, ax = plt.subplots(figsize=(9, 3.5), layout="constrained")
for name, run in (
    ("order 2", response),
    ("order 3", smooth),
    ("order 2 behind a jerk filter", filtered),
):
    ax.plot(run.time, run.states[2], label=name)
ax.set(xlabel="time [s]", ylabel="acceleration [deg/s²]", title="Acceleration of three followers")
ax.legend(bbox_to_anchor=(1.0, 0.5), loc="center left")
ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## A move modified under way
#
# The vocabulary of motion controllers. The old S-curve, given by a jerk percent, plans a
# modification as if the acceleration were zero, so that it steps; the plan with jerks takes it as
# it is.

# %%
with_jerk = s_curve_move(
    10.0,
    velocity=4.0,
    acceleration=8.0,
    deceleration=6.0,
    acceleration_jerk=40.0,
    deceleration_jerk=30.0,
)
by_percent = s_curve_move(  # 0.6 of jerk time raises the peaks to 8 and 6
    10.0, velocity=4.0, acceleration=5.6, deceleration=4.2, jerk_percent=0.6
)
modified = {
    "by jerk percent": by_percent.modify(0.3, target=4.0),
    "with jerks": with_jerk.modify(0.3, target=4.0),
}
figure, axes = plt.subplots(1, 3, figsize=(12, 3.5), layout="constrained")
for derivative, ax in enumerate(axes):
    plot_motions(modified, derivative, ax=ax, unit="mm")
    ax.axvline(0.3, color="0.4", linewidth=0.8, linestyle=":")
axes[0].legend(loc="lower right")
figure.suptitle("Target changed from 10 mm to 4 mm after 0.3 s")
plt.show()

# %% [markdown]
# ## A tracked ramp
#
# A telescope tracks at a constant rate. Told where the target is, the follower stays behind it;
# told its velocity as well, it does not.

# %%
tracker = CommandFollower(limits, dt=0.01)
ramp = 3.0 + 0.8 * time
without = tracker.run(ramp)
along = tracker.run(ramp, command_velocities=0.8)
target = 3.0 + 0.8 * without.time

figure, ax = plt.subplots(figsize=(8, 3.2), layout="constrained")
ax.plot(without.time, target - without.states[0], label="position commanded")
ax.plot(along.time, target - along.states[0], "--", label="position and velocity commanded")
ax.set(xlabel="time [s]", ylabel="target − position [deg]", title="Lag behind a ramp of 0.8 deg/s")
ax.legend()
ax.grid(alpha=0.3)
plt.show()
print(f"lag at the end: {target[-1] - without.states[0, -1]:.4f} deg and "
      f"{abs(target[-1] - along.states[0, -1]):.0e} deg")  # fmt: skip

# %% [markdown]
# ## An axis that goes round
#
# From 350° to 10° the short way is 20° on.

# %%
azimuth = CommandFollower(Limits(velocity=60.0, acceleration=60.0), dt=0.01, period=360.0)
headings = np.select([time < 6.0, time < 11.0], [10.0, 200.0], default=350.0)
turn = azimuth.run(headings, initial=(350.0,))

figure, ax = plt.subplots(figsize=(9.5, 3.2), layout="constrained")
plot_following(turn, ax=ax, unit="deg")
ax.axhspan(360.0, 400.0, color="0.92", label="beyond a full turn")
ax.set_title("The short way round, position counted on")
ax.set_ylim(0.0, 400.0)
ax.legend(bbox_to_anchor=(1.0, 0.5), loc="center left")
plt.show()

# %% [markdown]
# ## Axes that belong together
#
# Three axes with different distances: started together, ended together, both, or kept on the
# straight line.

# %%
axes_of_stage = [
    (0.0, 40.0, Limits(velocity=10.0, acceleration=20.0, jerk=200.0)),
    (0.0, 12.0, Limits(velocity=10.0, acceleration=20.0, jerk=200.0)),
    (5.0, -1.0, Limits(velocity=10.0, acceleration=20.0, jerk=200.0)),
]
figure, panels = plt.subplots(1, 4, figsize=(13, 3.3), sharey=True, layout="constrained")
for ax, mode in zip(panels, ("start", "end", "both", "straight-line"), strict=True):
    together = synchronize(axes_of_stage, mode)
    plot_motions(dict(zip("xyz", together, strict=True)), 1, ax=ax, unit="mm")
    ax.set_title(mode)
for ax in panels[1:]:
    ax.set_ylabel("")
panels[0].legend(loc="lower right")
plt.show()
