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
# # A first move
#
# A *shaper* turns "go there" into a trajectory whose derivatives are bounded. Here a telescope
# axis moves by one degree, first with bounds on velocity, acceleration and jerk.

# %%
import matplotlib.pyplot as plt
import numpy as np

from jounce.shaping import (
    JerkFilter,
    Limits,
    bound_for_rise_time,
    min_jerk_move,
    min_time_move,
    perfect_spline,
)

limits = Limits(velocity=0.5, acceleration=0.4, jerk=1.0)  # deg, s
move = min_time_move(1.0, limits)
move

# %% [markdown]
# A trajectory is a function of time, and so are its derivatives. Peaks are exact: they come from
# the extrema of the polynomials, not from samples.

# %%
print(f"duration {move.duration:.6f} s, switches at {np.round(move.switch_times, 4)}")
for name in ("velocity", "acceleration", "jerk"):
    print(f"{name:13s} peak {move.peak(name):.6g}, limit {limits.bounds(name)[1]:g}")
assert move.violation(limits) < 1e-12

# %%
times, states = move.sample(0.002)
figure, axes = plt.subplots(4, 1, sharex=True, figsize=(7, 7), layout="constrained")
for ax, values, label in zip(
    axes,
    states,
    ["position [deg]", "velocity [deg/s]", "acceleration [deg/s²]", "jerk [deg/s³]"],
    strict=True,
):
    ax.plot(times, values)
    ax.set_ylabel(label)
    ax.grid(alpha=0.3)
axes[-1].set_xlabel("time [s]")
figure.suptitle("One degree within velocity, acceleration and jerk limits")
plt.show()

# %% [markdown]
# ## Higher derivatives
#
# With only the highest derivative bounded the fastest move is a perfect spline: its switches lie
# at $T\sin^2(k\pi/2n)$. The peaks below are for the same distance and the same duration.

# %%
figure, ax = plt.subplots(figsize=(9, 3.5), layout="constrained")
for order, name in ((2, "acceleration"), (3, "jerk"), (4, "snap"), (5, "crackle"), (6, "pop")):
    unit = perfect_spline(1.0, order, 1.0)
    spline = unit.stretch(1.0 / unit.duration)
    time = np.linspace(0.0, 1.0, 400)
    ax.plot(time, spline(time, "velocity"), label=f"order {order}: {name} bounded")
ax.set(xlabel="time / duration", ylabel="velocity · duration / distance")
ax.set_title("Perfect splines of the same duration")
ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## A rise time in place of a bound
#
# Nobody knows the pop that a telescope stands, but a rise time of the acceleration is easy to
# name: Thompson's "longer move" with 0.2 deg/s² reached in one second.

# %%
pop = bound_for_rise_time(acceleration=0.2, rise_time=1.0, order=6)
longer = min_time_move(2.0, Limits(acceleration=0.2, pop=pop), method="closed-form")
print(f"pop bound {pop:.4g} deg/s⁶, duration {longer.duration:.4f} s")

# %% [markdown]
# ## A filter behind the shaper, and the minimum-jerk move
#
# The linear jerk filter smooths any command and never overshoots; its response here is exact, for
# position and all derivatives up to its order.

# %%
coarse = min_time_move(1.0, Limits(acceleration=0.4))
filtered = JerkFilter(corner_hz=2.0, order=6).respond(coarse, dt=0.002)
quintic = min_jerk_move(1.0, duration=coarse.duration)

figure, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
time = np.linspace(0.0, filtered.time[-1], 1000)
ax.plot(time, coarse(time, "velocity"), label="acceleration-limited")
ax.plot(filtered.time, filtered.states[1], label="behind a jerk filter, 2 Hz × 6")
ax.plot(time, quintic(time, "velocity"), label="minimum jerk")
ax.set(xlabel="time [s]", ylabel="velocity [deg/s]", title="Three ways to smooth one degree")
ax.legend()
ax.grid(alpha=0.3)
plt.show()
