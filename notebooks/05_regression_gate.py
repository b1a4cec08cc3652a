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
# # Margins that stay checked
#
# A loop is surveyed once and its numbers are stored. From then on every change of a gain, a limit
# or a library is held to them: by `jounce check` in continuous integration, by
# `margins_regression` in a test-suite, or from Python as here.

# %%
import shutil
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from jounce.analysis import loop_margins, servo_margins
from jounce.app import check_scenario
from jounce.plant import Inertia, ServoLoop, design_pid

folder = Path(tempfile.mkdtemp())
for name in ("telescope.toml", "telescope.check.toml", "telescope.baseline.json"):
    shutil.copy(Path("../examples") / name, folder)
scenario = folder / "telescope.toml"

# %% [markdown]
# ## The loop that is guarded
#
# Thompson's Figure 10: the survey of Section VII.

# %%
# %matplotlib inline
sys.path.insert(0, "../docs")  # where the paper's figures are drawn
from figures.paper import figure_10

figure_10()

# %% [markdown]
# ## As it was stored
#
# A check file beside the scenario names bounds, such as `phase_margin_deg = { min = 44 }`; the
# baseline holds every number with its tolerance, and all that the numbers depend on.

# %%
report = check_scenario(scenario)
print(report.passed, len(report.rows), "numbers")
print((folder / "telescope.check.toml").read_text().partition("[margins]")[2][:110])

# %% [markdown]
# ## A colleague lowers the crossover
#
# The phase margin is as before, the loop only slower. What is asked has changed, and what got worse
# fails; each row says what was, what is, and what is allowed. On the command line the exit status
# is 1.

# %%
scenario.write_text(scenario.read_text().replace('crossover = "1 Hz"', 'crossover = "0.9 Hz"'))
slower = check_scenario(scenario)
print(slower.passed)
for row in slower.failures:
    print(row.message)

# %% [markdown]
# ## Another one loosens a tolerance
#
# The moves settle sooner, but to another tolerance: a number that means something else is no
# improvement. What is asked and given must be as it was stored, until `--update` accepts it; only
# the design (gains, the feedforward's inertia) may change as long as the numbers pass.
# `overrides` is what `--set` gives on the command line.

# %%
loosened = check_scenario("../examples/telescope.toml", overrides={"moves[0].settle_to": "500 mas"})
print(loosened.passed)
for row in (*loosened.failures, *loosened.notes):
    print(row.message)

# %% [markdown]
# ## What a delay costs
#
# The same loop behind a pure delay, which is not approximated, and as a digital controller: sampled
# every 10 ms, its torque 4 ms late.

# %%
pid = design_pid(1.0, crossover_hz=1, phase_margin_deg=45, lower_gain_margin_db=12)
loop = ServoLoop(Inertia(1.0), pid)
print(loop_margins(loop.loop_transfer(), delay=0.009), "\n")
print(loop_margins(loop.sampled_loop_transfer(0.01, delay=0.004)))

# %% [markdown]
# How much inertia and delay does it bear? A hundred thousand loops at once, and their contours:

# %%
inertias, delays = np.geomspace(0.25, 4.0, 316), np.linspace(0.0, 0.2, 317)
grid = servo_margins(inertias, pid, delay=delays[:, None])
print(grid.stable.size, "loops,", grid.stable.sum(), "of them stable")

figure, panels = plt.subplots(1, 2, figsize=(12, 4.5), layout="constrained", sharey=True)
for ax, margin in zip(panels, ("phase_margin_deg", "upper_gain_margin_db"), strict=True):
    grid.plot(inertias, delays, margin=margin, ax=ax)
    ax.set(xlabel="inertia [kg m²]", ylabel="delay [s]", xscale="log")
plt.show()

# %%
shutil.rmtree(folder)
