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
# # The minimum time, with a proof
#
# Up to jerk the S-curve is the fastest move there is. From snap on it is not: motion controllers
# plan higher orders by recursion, each derivative a pulse of the one below, and that takes longer
# than need be. `min_time_move` finds the true minimum, and `certify` proves how near it came.

# %%
import matplotlib.pyplot as plt
import numpy as np

from jounce.shaping import (
    Limits,
    certify,
    min_jerk_move,
    min_time_move,
)
from jounce.shaping.recursive_s_curve import recursive_s_curve

# %% [markdown]
# ## Snap, crackle or pop limited, and nothing else
#
# Thompson's Figure 4, with the recursion beside it: the same distance, the same bound, time over
# the minimum time. The optimum switches its highest derivative at T·sin²(kπ/2n), more often near
# the ends. The recursion cuts the move into 2ⁿ⁻¹ equal steps, in the order + − − + − + + − …, where
# two steps of one sign make a pulse of double width, and pays 7, 22 and 43 % for it.

# %%
# %matplotlib inline
names = {4: "snap", 5: "crackle", 6: "pop"}
figure, axes = plt.subplots(4, 3, figsize=(11, 8), sharex=True, layout="constrained")
for column, (order, name) in zip(axes.T, names.items(), strict=True):
    limits = Limits.from_bounds([None] * (order - 1) + [1.0])
    optimum, recursion = min_time_move(1.0, limits), recursive_s_curve(1.0, limits)
    unit = optimum.duration
    moves = {"recursion": (recursion, "C0", column[2]), "minimum time": (optimum, "C1", column[3])}
    for label, (move, color, own) in moves.items():
        time = np.linspace(0.0, move.duration, 2000)
        column[0].plot(time / unit, move(time), color, label=label)
        column[1].plot(time / unit, move(time, "velocity") * unit, color)
        own.stairs(move.states[:, order], move.breaks / unit, color=color)
    column[0].set_title(f"{name} limited: {recursion.duration / unit - 1.0:.0%} longer")
    column[3].set_xlabel("time / minimum time")
axes[0, 0].legend()
labels = (
    "position / distance",
    "velocity · T / distance",
    "recursion:\nhighest / bound",
    "minimum time:\nhighest / bound",
)
for ax, label in zip(axes[:, 0], labels, strict=True):
    ax.set_ylabel(label)
for ax in axes.flat:
    ax.grid(alpha=0.3)
plt.show()

# %% [markdown]
# ## Several limits at once
#
# Real axes have a bound on every derivative. Then not even the best closed form is the fastest, and
# the exact optimum may switch infinitely often, so that no table of switches attains it. A linear
# program comes near it with a motion that keeps every bound at every instant.

# %%
# deg, s
limits = Limits(velocity=1.5, acceleration=6.0, jerk=60.0, snap=700.0, crackle=1e4, pop=1.5e5)
recursion = recursive_s_curve(1.0, limits)
closed = min_time_move(1.0, limits, method="closed-form")
move = min_time_move(1.0, limits)
for name, each in (("recursion", recursion), ("closed form", closed), ("optimal", move)):
    excess = max(each.violation(limits), 0.0)
    print(f"{name:12}{each.duration:.6f} s, {len(each.states):3} pieces, over a bound {excess:.0e}")

# %% [markdown]
# Colour shows which limit holds the move back at which time. A curve is thick and orange where it
# is within 0.1 % of its limit, the dashed line, and a band marks a piece all along which it stays
# there. Velocity and acceleration touch their limits; jerk and snap keep clear of theirs.

# %%
_ = move.plot(limits, unit="deg")

# %% [markdown]
# ## What a certificate says
#
# No motion whatever within these limits, from rest to rest over this distance, takes less than
# `lower_bound`: it is computed from multipliers by weak duality, and holds however the solver came
# by them. So the gap says how much could still be gained at most.

# %%
proof = certify(move, limits, rtol=1e-4)
print(f"duration       {proof.duration:.6f} s")
print(f"proven minimum {proof.lower_bound:.6f} s")
print(f"gap            {proof.gap:.1e} (asked for {proof.rtol:g}: {proof.reached})")
for name, slower in (("closed form", closed), ("recursion", recursion)):
    print(f"the {name} is {slower.duration / proof.lower_bound - 1.0:.1%} slower than that")

# %% [markdown]
# ## Which limit costs the time
#
# The multipliers are prices: what a limit raised by 1 % would save. They add up, Σ k·sensitivity of
# derivative k = −1, because scaling time scales every limit.

# %%
derivatives = ("velocity", "acceleration", "jerk", "snap", "crackle", "pop")
prices = -np.array(proof.sensitivities)
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.bar(derivatives, prices)
ax.set_ylabel("saved [% of duration]")
ax.set_title("What raising each limit by 1 % saves")
ax.grid(alpha=0.3, axis="y")
plt.show()

# %% [markdown]
# A prediction to be held to: 5 % more of the dearest limit.

# %%
k = int(np.argmax(prices))
bounds = [limits.bounds(name)[1] for name in derivatives]
bounds[k] *= 1.05
faster = min_time_move(1.0, Limits.from_bounds(bounds))
print(f"5 % more {derivatives[k]}: {1.0 - 1.05 ** -prices[k]:.2%} predicted, ", end="")
print(f"{1.0 - faster.duration / move.duration:.2%} saved")

# %% [markdown]
# ## Anybody's motion
#
# A certificate asks for nothing but a move from rest to rest. The minimum-jerk polynomial, say,
# against the limits that it uses itself:

# %%
smooth = min_jerk_move(1.0, duration=1.0)
used = Limits(*(smooth.peak(name) for name in ("velocity", "acceleration", "jerk")))
proof = certify(smooth, used)
print(
    f"with the same peaks {proof.lower_bound:.4f} s would do: {proof.gap:.0%} longer than need be"
)
