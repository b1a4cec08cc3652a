"""What a describing function is swept over: checked, the limits in units of each sine."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...shaping import CommandFollower, Limits
from ...shaping.checks import whole
from ...shaping.limits import check_plain, of_one
from ...shaping.real_numbers import shown
from ...shaping.trajectory_checks import finite_array
from ...shaping.transfers.problem import check_order

if TYPE_CHECKING:
    from ...shaping.pieces import FloatArray
    from .periodic import Counts

SAMPLES_PER_PERIOD = 1024
"""Of a follower given by its limits, unless told otherwise."""

_FEWEST, _MOST = 8, 20_000  # samples per period
_NEVER_MET = 1e100  # a bound, in units of the sine


class Sweep(NamedTuple):
    """A checked problem: bounds (order, …) in units of the sine, samples per period if sampled."""

    amplitude: FloatArray
    omega: FloatArray
    bounds: FloatArray
    counts: Counts | None


def checked_sweep(
    shaper: Limits | CommandFollower,
    amplitude: ArrayLike,
    omega: ArrayLike,
    samples_per_period: int | None = None,
) -> Sweep:
    """Return the problem of `describing_function`, checked."""
    if not isinstance(shaper, Limits | CommandFollower):
        raise TypeError(
            f"shaper = {shown(shaper)}: expected Limits or a CommandFollower; what is linear, such "
            "as a jerk filter, has a frequency_response"
        )
    sizes, frequencies = _positive_pair(amplitude, omega)
    limits, counts = of_one(shaper) if isinstance(shaper, Limits) else shaper.limits, None
    if isinstance(shaper, CommandFollower):
        counts, frequencies = _whole_periods(shaper, frequencies, samples_per_period)
    elif limits.order > 1:
        check_order(limits)
        counts = np.full(sizes.shape, _even(samples_per_period))
    bounds = _in_units_of_the_sine(limits, sizes, frequencies)
    for array in (sizes, frequencies):
        array.flags.writeable = False
    return Sweep(sizes, frequencies, bounds, counts)


def _positive_pair(amplitude: ArrayLike, omega: ArrayLike) -> list[FloatArray]:
    """Return amplitude and omega as arrays of one shape, checked."""
    arrays = []
    for name, values in (("amplitude", amplitude), ("omega", omega)):
        array = finite_array(name, values)
        if (array <= 0.0).any():
            raise ValueError(f"{name} = {array.min()}: expected positive numbers")
        arrays.append(array)
    try:
        return [np.array(array) for array in np.broadcast_arrays(*arrays)]
    except ValueError:
        raise ValueError(
            f"amplitude of shape {arrays[0].shape} and omega of shape {arrays[1].shape} do not "
            "fit: for a sweep over both give amplitude[:, None] and omega"
        ) from None


def _even(samples_per_period: int | None) -> int:
    if samples_per_period is None:
        return SAMPLES_PER_PERIOD
    count = whole("samples_per_period", samples_per_period, _FEWEST, _MOST)
    if count % 2:
        raise ValueError(f"samples_per_period = {count}: expected an even number")
    return count


def _whole_periods(
    follower: CommandFollower, omega: FloatArray, samples_per_period: int | None
) -> tuple[Counts, FloatArray]:
    """Return even numbers of samples per period, and the frequencies that have them."""
    if samples_per_period is not None:
        raise ValueError(
            f"samples_per_period = {samples_per_period!r}: the follower has its own dt; give its "
            "limits alone to choose the samples"
        )
    if follower.period is not None:
        raise ValueError(
            f"positions of the follower repeat after {follower.period}, for a sine they must not: "
            "leave its period out"
        )
    with np.errstate(over="ignore"):
        exact = pi / omega / follower.dt
        halves = np.rint(exact)
    wrong = (2.0 * halves < _FEWEST) | (2.0 * halves > _MOST)
    if wrong.any():
        first, count = omega[wrong][0], 2.0 * exact[wrong][0]
        raise ValueError(
            f"omega = {first:.6g}: a period is {count:.6g} samples of dt = "
            f"{follower.dt:.6g}, expected {_FEWEST} to {_MOST}; leave this frequency out, or give "
            "the limits alone to have the samples chosen"
        )
    return 2 * halves.astype(np.intp), np.asarray(pi / (halves * follower.dt))


def _in_units_of_the_sine(limits: Limits, amplitude: FloatArray, omega: FloatArray) -> FloatArray:
    """Return L_k/(A·ω^k), (order, …)."""
    check_plain(limits)
    if not limits.symmetric:
        raise ValueError(
            f"{limits!r}: expected the same bounds in both directions; with others the output "
            "keeps an offset that a describing function does not tell"
        )
    rows = []
    with np.errstate(over="ignore", under="ignore"):
        for k, bound in enumerate(limits.upper, start=1):
            row = bound / amplitude
            for _ in range(k):
                row = row / omega
            rows.append(np.minimum(row, _NEVER_MET))
    if (np.array(rows) < 1.0 / _NEVER_MET).any():
        raise ValueError(
            f"{limits!r} and the sine are more than {_NEVER_MET:g} times apart: choose amplitudes "
            "and frequencies nearer to the limits"
        )
    return np.array(rows)
