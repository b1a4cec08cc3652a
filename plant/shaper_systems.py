"""Shaper blocks as python-control systems."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..shaping import JerkFilter
from ..shaping.checks import whole
from ..shaping.jerk_filter import checked_filter

if TYPE_CHECKING:
    import control


def filter_system(jerk_filter: JerkFilter, *, derivatives: int = 0) -> control.StateSpace:
    """Return a jerk filter as a python-control system r → y.

    Parameters
    ----------
    jerk_filter : JerkFilter
    derivatives : int, optional
        Number of derivatives of the output given beside it, as y_1, y_2, …; at most
        order − 1, so that none needs the command itself.

    Returns
    -------
    control.StateSpace
        Input r, outputs y (, y_1, …), states lag_1 … lag_m.
    """
    import control

    m = checked_filter(jerk_filter).order
    derivatives = whole("derivatives", derivatives, 0, m - 1)
    a, b = jerk_filter.state_space()
    rows = [np.eye(m)[-1]]
    for _ in range(derivatives):
        rows.append(rows[-1] @ a)
    return control.ss(
        a,
        b,
        np.array(rows),
        np.zeros((len(rows), 1)),
        inputs=["r"],
        outputs=["y"] + [f"y_{k}" for k in range(1, derivatives + 1)],
        states=[f"lag_{j}" for j in range(1, m + 1)],
        name="jerk_filter",
    )
