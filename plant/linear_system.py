"""Python-control systems of given matrices, with states or without."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import control


def linear_system(
    matrices: Sequence[Any],
    dt: float | None,
    *,
    inputs: Sequence[str],
    outputs: Sequence[str],
    states: Sequence[str] = (),
    name: str | None = None,
) -> control.StateSpace:
    """Return x_{k+1} = A·x_k + B·u_k (or ẋ = A·x + B·u), y = C·x + D·u; without states, y = D·u.

    Parameters
    ----------
    matrices : A, B, C, D
        Without states only D counts.
    dt : float or None
        Sampling time, 0 for continuous time, None for either.
    inputs, outputs, states : sequences of str
        Names of the signals.
    name : str, optional
        Default: python-control's next one.
    """
    import control

    a, b, c, d = matrices
    static = not states
    if static:
        # A state that nothing drives or sees is left out again. Of empty matrices python-control
        # sets the shapes in place, which numpy deprecates from 2.5 on.
        rows, columns = np.shape(d)
        a, b, c = np.zeros((1, 1)), np.zeros((1, columns)), np.zeros((rows, 1))
    return control.StateSpace(
        *(a, b, c, d, dt),
        inputs=list(inputs),
        outputs=list(outputs),
        states=["none"] if static else list(states),
        name=name,
        remove_useless_states=static,
    )


def static_gain(
    d: Any,
    dt: float | None = None,
    *,
    inputs: Sequence[str],
    outputs: Sequence[str],
    name: str | None = None,
) -> control.StateSpace:
    """Return y = D·u, a python-control system without states."""
    return linear_system(((), (), (), d), dt, inputs=inputs, outputs=outputs, name=name)
