"""An FMU as a discrete python-control system, evaluated repeatably by going back in its states."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Sequence
from hashlib import blake2b
from typing import TYPE_CHECKING, Any

import numpy as np

from ...shaping.checks import positive, whole
from ...shaping.pieces import FloatArray
from .agreement import answers_alike
from .description import FmuError
from .rewindable import Rewindable

if TYPE_CHECKING:
    import control

MAX_SNAPSHOTS = 100_000
"""Snapshots that may be kept."""

_CHECKED_STEPS = 100
_START = (0.0, 0.0)
_FINGERPRINT_BITS = 53  # whole numbers of a double


def io_system(
    fmu: Rewindable, dt: float | None = None, *, snapshots: int = 64
) -> control.NonlinearIOSystem:
    """Return a loaded FMU as a discrete python-control system.

        x_{k+1} = the FMU after one step of dt from x_k with u_k held,   y_k = its outputs at x_k

    So y_k depends on inputs up to u_{k−1}: a plant that is fed through a hold has no extra sample
    of delay, and an output that jumps with the input shows the jump at the end of the step.
    python-control evaluates a system as often as it likes; each evaluation here goes back to the
    snapshot that belongs to the state, steps, and keeps the snapshot of the result.

    Parameters
    ----------
    fmu : Fmu
        Its present state is the system's initial state, zero. It stays open as long as the
        system is used; where it stands afterwards is where the last evaluation left it.
    dt : float, optional
        Communication step. Default: `fmu.dt`.
    snapshots : int, optional
        How many to keep, beside the initial one; the least recently used are dropped.

    Returns
    -------
    control.NonlinearIOSystem
        Inputs and outputs named as the FMU's, with what python-control cannot have in a name
        replaced by "_". States: `step`, how many steps have been taken, and `history`, a
        fingerprint of the inputs that led there; neither is a quantity of the model.

    Raises
    ------
    FmuError
        For an FMU that cannot get and set its state, has no dt, or answers otherwise while a
        snapshot of it is kept than it does without (100 steps of a second instance are tried).
        Evaluated at a state that is none of its own or whose snapshot was dropped, the system
        raises it too.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> import control
    >>> from jounce.plant import Inertia
    >>> from jounce.fmu import export_fmu
    >>> from jounce.fmu.exporting.compile import host_platform
    >>> from jounce.fmu.importing.load import load_fmu
    >>> gains = control.nlsys(None, lambda t, x, u, params: u[0] - u[1] - 2.0 * u[2], dt=0.5,
    ...                       inputs=["r", "y", "y_rate"], outputs=["u"], name="controller")
    >>> with TemporaryDirectory() as folder:
    ...     here = [host_platform()]
    ...     written = export_fmu(Inertia(2.0), f"{folder}/plant.fmu", platforms=here)
    ...     with load_fmu(written.path) as fmu:
    ...         loop = control.interconnect([io_system(fmu, 0.5), gains], inputs="r", outputs="y")
    ...         run = control.input_output_response(loop, 0.5 * np.arange(3), np.ones(3))
    >>> run.outputs.tolist()
    [0.0, 0.0625, 0.21484375]
    """
    import control

    dt = positive("dt", fmu.dt if dt is None else dt)
    fmu.check_rollback("be evaluated repeatedly, as python-control does")
    if not answers_alike(fmu, dt, _CHECKED_STEPS):
        raise FmuError(
            f"{fmu.description.model_name} answers otherwise while a snapshot of it is kept "
            "(noSetFMUStatePriorToCurrentPoint false) than it does without, so it cannot be "
            "evaluated repeatedly, as python-control does; use `cosimulate` or a plain loop of "
            "`step`, or linearize_fmu just after load_fmu"
        )
    states = _Snapshots(fmu, dt, whole("snapshots", snapshots, 2, MAX_SNAPSHOTS))
    return control.NonlinearIOSystem(
        lambda t, x, u, params: states.step(x, u),  # noqa: ARG005
        lambda t, x, u, params: states.outputs(x),  # noqa: ARG005
        inputs=plain_names(fmu.input_names),
        outputs=plain_names(fmu.output_names),
        states=["step", "history"],
        name=plain_names([fmu.description.model_name])[0],
        dt=dt,
    )


class _Snapshots:
    """States of an FMU by (step, history), each with its outputs; a bounded number of them."""

    def __init__(self, fmu: Rewindable, dt: float, most: int) -> None:
        self._fmu = fmu
        self._dt = dt
        self._most = most
        self._initial = fmu.get_state(), fmu.outputs
        self._kept: OrderedDict[tuple[float, float], tuple[Any, FloatArray]] = OrderedDict()

    def outputs(self, x: Any) -> FloatArray:
        return self._at(_key(x))[1]

    def step(self, x: Any, u: Any) -> FloatArray:
        key = _key(x)
        inputs = np.array(u, dtype=float).reshape(-1)
        following = key[0] + 1.0, _fingerprint(key[1], inputs)
        if following not in self._kept:
            state, _ = self._at(key)
            self._fmu.set_state(state)
            outputs = self._fmu.step(inputs, self._dt)
            self._kept[following] = self._fmu.get_state(), outputs
            if len(self._kept) > self._most:
                self._kept.popitem(last=False)
        return np.array(following)

    def _at(self, key: tuple[float, float]) -> tuple[Any, FloatArray]:
        if key == _START:
            return self._initial
        found = self._kept.get(key)
        if found is None:
            raise FmuError(
                f"state (step, history) = {key}: no snapshot of it is kept. Start at zero and let "
                "python-control step the system; for going further back raise snapshots= (now "
                f"{self._most}). For a linear model use linearize_fmu, not control.linearize"
            )
        self._kept.move_to_end(key)
        return found


def _key(x: Any) -> tuple[float, float]:
    return float(x[0]), float(x[1])


def _fingerprint(history: float, inputs: FloatArray) -> float:
    digest = blake2b(np.float64(history).tobytes() + (inputs + 0.0).tobytes(), digest_size=8)
    return float(int.from_bytes(digest.digest(), "little") >> (64 - _FINGERPRINT_BITS)) or 1.0


def plain_names(names: Sequence[str]) -> list[str]:
    """Return names that python-control can tell apart from its own syntax, all different."""
    found: list[str] = []
    for name in names:
        plain = re.sub(r"\W+", "_", name).strip("_") or "signal"
        while plain in found:
            plain += "_"
        found.append(plain)
    return found
