"""Whether a closed loop with a pure delay is stable, by Mikhailov's criterion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .frequency_points import frequency_points

if TYPE_CHECKING:
    import control

_COARSE = 0.5  # a step of the phase, in rad, that is halved
_ROUNDS = 40


def is_stable(system: control.StateSpace | control.TransferFunction, delay: float = 0.0) -> bool:
    """Return whether all zeros of 1 + L are on the left, L = G(s)·e^(−s·delay), or within |z| = 1.

    A loop without delay by its poles. Else with G = N/D, D of degree n, the phase of

        Δ(jω) = D(jω) + N(jω)·e^(−jω·delay)

    rises by n·π/2 over ω = 0…∞ if no zero of Δ lies on the right (Mikhailov), by π less for
    each that does. Δ(jω) is followed until its phase turns by less than 0.5 rad a step.
    """
    if not delay:
        poles = system.feedback().poles()
        inside = abs(poles) < 1.0 if system.isdtime(strict=True) else poles.real < 0.0
        return bool(inside.all())
    zeros, poles = system.zeros(), system.poles()
    points = frequency_points(system, delay)
    gain = _gain(system, zeros, poles)

    def scaled(omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return Δ(jω) over a positive number of the size of D."""
        s = 1j * omega[:, None]
        sizes = np.hypot(omega[:, None], abs(poles) + points[0])
        numerator = (s - zeros).prod(axis=1) * (gain / sizes.prod(axis=1))
        return np.asarray(((s - poles) / sizes).prod(axis=1) + numerator * np.exp(-s[:, 0] * delay))

    omega = np.concatenate([[0.0], points])
    for _ in range(_ROUNDS):
        values = scaled(omega)
        turns = np.angle(values[1:] / values[:-1])
        coarse = abs(turns) > _COARSE
        if not coarse.any():
            break
        omega = np.sort(np.concatenate([omega, 0.5 * (omega[1:] + omega[:-1])[coarse]]))
    return bool(np.rint((len(poles) * 0.5 * np.pi - turns.sum()) / np.pi) == 0.0)


def _gain(
    system: control.StateSpace | control.TransferFunction,
    zeros: NDArray[np.complex128],
    poles: NDArray[np.complex128],
) -> float:
    """Return the factor of Π(s − zeros)/Π(s − poles), at a place far from both."""
    place = 3.0 * max(1.0, abs(np.concatenate([zeros, poles])).max(initial=0.0))
    return float((system(place) * (place - poles).prod() / (place - zeros).prod()).real)
