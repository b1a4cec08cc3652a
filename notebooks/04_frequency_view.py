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
# # Shapers as low-pass filters
#
# A step of a command goes into a shaper, a smooth move comes out. Seen that way a shaper is a
# low-pass filter, and its frequency response is the spectrum of the move's velocity over its
# distance, $H(j\omega) = \frac{1}{R}\int v(t)\,e^{-j\omega t}\,dt$ (Thompson, Section VI). It tells
# what a move leaves ringing.

# %%
import sys

import control
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import display

from jounce.analysis import (
    cascaded_lags,
    corner_omega,
    describing_function,
    fft_frequency_response,
    first_order_lag,
    frequency_response,
    null_by_size,
    null_omegas,
    periodic_response,
    place_null,
    rate_limiter_corner_omega,
    residual_vibration,
    rollover_db_per_decade,
    vibration_map,
)
from jounce.plant import respond
from jounce.plots import (
    plot_describing_function,
    plot_null_by_size,
    plot_periodic_response,
    plot_vibration_by_size,
    plot_vibration_map,
)
from jounce.shaping import Limits, min_time_move, perfect_spline

# %% [markdown]
# ## Exact, and by FFT
#
# Thompson takes the FFT of the sampled velocity, padded with zeros. A trajectory is a piecewise
# polynomial, so that its spectrum is known in closed form: `frequency_response` has no sampling
# interval, and is right at any frequency. To the FFT, what lies beyond half of the sampling
# frequency is folded back: little beside 1, but as much as there is at high frequencies.

# %%
move = min_time_move(1.0, Limits(velocity=1.25, acceleration=10.0))  # deg, s
sampled = fft_frequency_response(move, dt=0.02, padding=32)
exact = frequency_response(move, sampled.omega)
difference = np.abs(sampled.response - exact.response)
trusted = sampled.trusted_omega / (2 * np.pi)

figure, (gain, error) = plt.subplots(2, 1, sharex=True, figsize=(8, 5.5), layout="constrained")
frequency = sampled.omega / (2 * np.pi)
gain.plot(frequency, sampled.gain_db, color="tab:orange", label="FFT of 50 samples a second")
gain.plot(frequency, exact.gain_db, "k--", linewidth=1, label="exact")
gain.set(ylabel="|v| / R [dB]", ylim=(-100, 5), title="A move of 1 deg")
error.semilogy(frequency[1:], difference[1:], color="tab:orange")
error.set(xlabel="frequency [Hz]", ylabel="|FFT − exact|", ylim=(1e-5, 1e-2))
for ax in (gain, error):
    ax.axvline(trusted, color="0.4", linestyle=":", label=f"trusted up to {trusted:.3g} Hz")
    ax.grid(alpha=0.3)
gain.legend()
plt.show()

# %% [markdown]
# ## Perfect splines and the jerk filter
#
# Moves of equal duration, of order 2 to 6, beside six lags of 2 Hz: the paper's Figure 8.

# %%
sys.path.insert(0, "../docs")  # where the paper's figures are drawn
from figures.paper import FIGURES

FIGURES[8]()

# %% [markdown]
# ## Corner, rollover and nulls
#
# Of two moves of equal duration the smoother one lets more pass at low frequencies, and less at
# high ones: each order falls by another 20 dB per decade. A move that is symmetric in time has true
# nulls; a mode there does not ring at all.

# %%
print("order  −3 dB [Hz]  dB/decade  nulls [Hz]")
for order in (2, 3, 4, 5, 6):
    spline = perfect_spline(1.0, order, 1.0)
    spline = spline.stretch(1.0 / spline.duration)
    corner = corner_omega(spline) / (2 * np.pi)
    nulls = null_omegas(spline, 2 * np.pi * 5.0) / (2 * np.pi)
    print(
        f"{order:5d}  {corner:10.4f}  {rollover_db_per_decade(spline):9.0f}  "
        + ", ".join(f"{null:.4f}" for null in nulls)
    )

# %% [markdown]
# ## Lags in series
#
# A rate limiter is often thought of as a first-order lag of time constant $R/V$, and a shaper as
# such lags in series. Their delay can be made that of the move; the nulls are lost, and so is the
# shape around the corner.

# %%
omega = 2 * np.pi * np.geomspace(0.05, 20.0, 800)
for match in ("delay", "rates"):
    lags = cascaded_lags(move, omega, match=match)
    print(f"{match:6s} time constants {np.round(lags.lags, 4)} s, "
          f"{lags.error_to_corner_db:+.2f} dB up to the corner")  # fmt: skip
    lags.plot()

# %% [markdown]
# ## What a move leaves ringing
#
# A lightly damped mode of the structure is driven by the acceleration of the axis. What is left
# after the move is $R\,|H|$ at the mode's frequency, or nearly so with damping:
# `residual_vibration` has the amplitude exactly. Here it is beside a simulation of the mode.

# %%
mode_hz, damping = 6.0, 0.01
mode_omega = 2 * np.pi * mode_hz
mode = control.ss(
    [[0.0, 1.0], [-(mode_omega**2), -2 * damping * mode_omega]], [[0.0], [-1.0]], [[1.0, 0.0]], 0.0
)
limits = Limits(velocity=1.25, acceleration=10.0, jerk=200.0)
moves = {
    "velocity and acceleration limited": move,
    "jerk limited, too": min_time_move(1.0, limits),
}


def draw_ringing(name, trajectory, ax):
    """Draw the simulated deflection of the mode, and the residual amplitude as it dies away."""
    rings = respond(mode, trajectory, 0.002, derivatives=(2,), duration=2.5)
    amplitude = 1000 * float(residual_vibration(trajectory, mode_hz, damping))
    after = rings.time[rings.time >= trajectory.duration]
    envelope = amplitude * np.exp(-damping * mode_omega * (after - trajectory.duration))
    ax.plot(rings.time, 1000 * np.squeeze(rings.outputs), label=name)
    ax.plot(after, envelope, "k--", linewidth=1, label=f"residual {amplitude:.4f} mdeg")
    ax.plot(after, -envelope, "k--", linewidth=1)
    ax.set_ylabel("deflection [mdeg]")
    ax.legend(loc="upper right")
    ax.grid(alpha=0.3)


figure, panels = plt.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
for ax, (name, each) in zip(panels, moves.items(), strict=True):
    draw_ringing(name, each, ax)
panels[0].set_title(f"A mode of {mode_hz:g} Hz, damping {damping:g}, during and after 1 deg")
panels[1].set_xlabel("time [s]")
plt.show()

# %% [markdown]
# Over the size of the move and the frequency of the mode, some nulls stay where they are, because a
# ramp has reached its full width; others move with the size.

# %%
sizes = np.geomspace(0.05, 2.0, 250)
modes = np.geomspace(1.0, 20.0, 250)
figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plot_vibration_map(vibration_map(limits, sizes, modes), ax=ax, unit="deg")
ax.axhline(mode_hz, color="w", linewidth=0.8, linestyle="--")
plt.show()

# %% [markdown]
# ## Placing a null
#
# Lowering one limit, here the jerk, puts a null on the mode. Once the ramp has its full width, the
# null stays there for all larger moves.

# %%
placed = place_null(1.0, limits, mode_hz, by="jerk")
quiet = min_time_move(1.0, placed)
print(f"jerk {limits.bounds('jerk')[1]:g} -> {placed.bounds('jerk')[1]:.6g} deg/s³")
print(f"duration {moves['jerk limited, too'].duration:.4f} -> {quiet.duration:.4f} s")
print(f"residual {residual_vibration(quiet, mode_hz):.1e} deg, with damping "
      f"{residual_vibration(quiet, mode_hz, damping):.1e} deg")  # fmt: skip

figure, ax = plt.subplots(figsize=(8, 2.6), layout="constrained")
draw_ringing("null on the mode", quiet, ax)
ax.set_xlabel("time [s]")
plt.show()

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.2), layout="constrained")
plot_null_by_size(null_by_size(placed, sizes[::12], mode_hz), ax=left, unit="deg")
nearby = [0.9 * mode_hz, mode_hz, 1.1 * mode_hz]
plot_vibration_by_size(vibration_map(placed, sizes, nearby), ax=right, unit="deg")
plt.show()

# %% [markdown]
# ## Describing functions
#
# A shaper that follows commands is not linear: how it answers a sine depends on its amplitude. For
# a rate limiter the corner is proportional to $V/A$, as in Thompson's rule $V/R$ for a step.

# %%
limiter = Limits(velocity=1.0)
amplitudes = np.array([0.1, 1.0, 10.0])
load = np.geomspace(0.1, 10.0, 200)  # A·ω/V
lag = first_order_lag(describing_function(limiter, amplitudes[:, None], load / amplitudes[:, None]))
for row in zip(
    amplitudes, rate_limiter_corner_omega(limiter, amplitudes), lag.corner_omega, strict=True
):
    print("A = {:4g} deg: −3 dB at {:.4g} rad/s, nearest first-order lag {:.4g} rad/s".format(*row))

swept = describing_function(limiter, amplitudes[:, None], np.geomspace(0.02, 200.0, 400))
_ = plot_describing_function(swept, lag=lag)

# %% [markdown]
# With the acceleration limited as well, a follower prepares to stop at every command, and so lags
# behind a sine that is within its limits (above), unless it is told the velocity of the command. A
# sine beyond them (below) comes out late and near to a triangle in any case.

# %%
follower = Limits(velocity=1.0, acceleration=2.0)
cases = {
    "rate limiter": (limiter, False),
    "follower": (follower, False),
    "follower, told the velocity": (follower, True),
}
figure, panels = plt.subplots(2, 3, figsize=(13, 5.8), sharex="row", layout="constrained")
for row, omega in zip(panels, (0.9, 2.0), strict=True):
    for ax, (name, (shaper, told)) in zip(row, cases.items(), strict=True):
        period = periodic_response(shaper, 1.0, omega, command_velocity=told)
        plot_periodic_response(period, ax=ax, unit="deg")
        ax.set_title(f"{name}: {omega:g} rad/s")
plt.show()

# %% [markdown]
# ## The figures of the paper
#
# Those of its shapers, each drawn by one function; `docs/gallery.md` has all of them, and what they
# show.

# %%
for number in (1, 2, 3, 4, 6, 7):
    display(FIGURES[number]())
