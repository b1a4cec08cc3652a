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
# # Minimum time between any motions, within any bounds
#
# Bounds need not be the same in both directions, an axis may move when its motion begins and
# ends, and a stage has hard stops. Here are four such jobs: a lift, a flying change between two
# motions, a stage between its stops, and a path of ten points. Every motion comes with a lower
# bound that is proven, but for the path.

# %%
import matplotlib.pyplot as plt
import numpy as np

from jounce.shaping import (
    InfeasibleError,
    Limits,
    certify,
    min_time_move,
    min_time_transfer,
    synchronize,
    through,
)

# %% [markdown]
# ## A lift that brakes harder than it starts
#
# Passengers bear 1 m/s² upwards, the brake gives 4 m/s². A planner that knows one bound per
# derivative has to take the smaller of the two.

# %%
# %matplotlib inline
lift = Limits(velocity=20.0, acceleration=(-4.0, 1.0), jerk=10.0, snap=100.0)
move = min_time_move(60.0, lift)
cautious = min_time_move(60.0, Limits(velocity=20.0, acceleration=1.0, jerk=10.0, snap=100.0))
proof = certify(move, lift)
print(f"minimum time   {move.duration:.4f} s, proven to be {proof.lower_bound:.4f} s at least")
print(
    f"smaller bounds {cautious.duration:.4f} s, {cautious.duration / move.duration - 1:.0%} longer"
)
_ = move.plot(lift, unit="m")

# %% [markdown]
# With time to spare it can be smoother: a given duration is met by the motion that needs the
# smallest share of its highest bound.

# %%
durations = move.duration * np.array([1.0, 1.01, 1.05, 1.2, 1.5])
for duration in durations:
    calm = min_time_move(60.0, lift, duration=duration)
    low, high = calm.extremes("snap")
    print(f"{duration:7.3f} s: snap {low:8.2f} to {high:6.2f} m/s⁴")

# %% [markdown]
# ## From one motion into another
#
# An axis of a bottling line runs at 0.9 m/s and is to be 1 m further, at 0.9 m/s again. It can
# pass in about a second, or turn back and take a new run. Between those durations there is
# none: where another axis takes 2 s, both need 2.9 s.

# %%
line = Limits(velocity=1.0, acceleration=1.0, jerk=4.0, snap=40.0)
start, end = (0.0, 0.9), (1.0, 0.9)
passing = min_time_transfer(start, end, line)
try:
    min_time_transfer(start, end, line, duration=2.0)
except InfeasibleError as error:
    print(error)
together = synchronize([(start, end, line), (0.0, 0.65, line)])
alone = min_time_move(0.65, line)
print(
    f"alone {passing.duration:.3f} s and {alone.duration:.3f} s, together {together.duration:.3f} s"
)

figure, axes = plt.subplots(1, 2, figsize=(10, 3.5), layout="constrained")
for label, motion in (("alone", passing), ("with the other axis", together[0])):
    time = np.linspace(0.0, motion.duration, 600)
    axes[0].plot(time, motion(time), label=label)
    axes[1].plot(time, motion(time, "velocity"))
axes[0].set_ylabel("position [m]")
axes[1].set_ylabel("velocity [m/s]")
axes[0].legend()
for ax in axes:
    ax.set_xlabel("time [s]")
    ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## A stage between hard stops
#
# A stage of ±4 mm is 1 µm from its stop and on the way away from it, but about to come back. The
# fastest way to stand at the stop overshoots it, if it may. (The states are an example that Wang
# and Hu published, in mm and ms.)

# %%
bounds = {"velocity": 1.5, "acceleration": 1.0, "jerk": 1.0}
free, stopped = Limits(**bounds), Limits(**bounds, position=(-4.0, 4.0))
begin, target = (3.999, -0.375, 1.0), 4.0
figure, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
for label, limits in (("position free", free), ("between stops", stopped)):
    motion = min_time_transfer(begin, target, limits)
    time = np.linspace(0.0, motion.duration, 800)
    ax.plot(time, motion(time), label=f"{label}: {motion.duration:.4f} ms")
ax.axhspan(4.0, 4.03, color="0.8", label="stop")
ax.set(xlabel="time [ms]", ylabel="position [mm]")
ax.legend(loc="lower right")
ax.grid(alpha=0.3)
plt.show()
stop_time = motion.duration

# %% [markdown]
# Where no motion keeps all bounds that is proven, and told with the time that is left and the
# nearest start from which it works.

# %%
try:
    min_time_transfer((3.5, 1.2), 0.0, stopped)
except InfeasibleError as error:
    print(error)
    slower = min_time_transfer(error.state, 0.0, stopped)
    print(f"from {error.nearest} mm/ms it takes {slower.duration:.3f} ms")

# %% [markdown]
# ## A path of ten points
#
# Three axes pass ten points in motion: velocities and accelerations there are chosen so that the
# whole is soonest, and within 5 cm of them is near enough.

# %%
points = np.random.default_rng(3).uniform(-1.0, 1.0, (10, 3))
gantry = Limits(velocity=1.0, acceleration=5.0, jerk=50.0, snap=1000.0)
stops = through(points, gantry, straight=True)
exact = through(points, gantry)
near = through(points, gantry, corner=0.05)
for label, path in (
    ("lines, a stop at each", stops),
    ("exactly through", exact),
    ("within 5 cm", near),
):
    print(f"{label:22}{path.duration:.3f} s")

figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
for color, (label, path) in zip(("0.7", "C0", "C1"), (
    ("lines", stops), ("through", exact), ("within 5 cm", near)), strict=True):  # fmt: skip
    time = np.linspace(0.0, path.duration, 2000)
    x, y, _ = (axis(time) for axis in path)
    axes[0].plot(x, y, color, label=label)
    speed = np.linalg.norm([axis(time, "velocity") for axis in path], axis=0)
    axes[1].plot(time, speed, color, label=label)
axes[0].plot(*points[:, :2].T, "k.", label="points")
axes[0].set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
axes[1].set(xlabel="time [s]", ylabel="speed along the path [m/s]")
axes[0].legend(fontsize="small")
for ax in axes:
    ax.grid(alpha=0.3)
plt.show()

# %%
figures = {
    "lift [s]": move.duration,
    "lift, smaller bounds [s]": cautious.duration,
    "together [s]": together.duration,
    "between stops [s]": stop_time,
    "path with stops [s]": stops.duration,
}
