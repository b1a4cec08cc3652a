"""The PID of largest integral gain under bounds on the peaks of S and T, for any axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ..plant import PID, Controller
from ..plant.discretise import Discretisation
from ..plant.frequency_points import frequency_points
from ..plant.open_gains import OpenGains, pure_delay
from ..shaping.checks import finite
from ..shaping.frozen import Frozen
from ..shaping.real_numbers import shown
from ..shaping.told import Told
from .integral_gain import Circle, Complex, Real, circles, clearance, largest_integral_gain
from .margins import LoopMargins, loop_margins
from .measured import MeasuredMargins, MeasuredResponse, as_measured, is_frd
from .measured.open_gains import MeasuredGains

_EXCESS = 1e-5  # by how much a peak may pass its bound between the points, relative
_ROUNDS = 30
_MOST_STARTS = 40
_AROUND = np.linspace(-1.0, 1.0, 61)
_SHAPES = ((0.35, 0.02), (0.82, 0.15), (0.2, 0.005), (1e-3, 1e-7))
"""Starts: kp and ki of a double integrator with unit crossover and kr."""


@dataclass(frozen=True, repr=False)
class TunedPID(Told, Frozen):
    """A tuned controller and the margins of its loop.

    Attributes
    ----------
    controller : Controller
        With the filters, sample time and delay that were given.
    margins : LoopMargins
        max |S| is its `sensitivity_peak`, max |T| its `complementary_peak`.
    programs : int
        Linear programs solved.
    """

    controller: Controller
    margins: LoopMargins | MeasuredMargins
    programs: int

    @property
    def pid(self) -> PID:
        """The gains."""
        law = self.controller.law
        assert isinstance(law, PID)
        return law

    def __str__(self) -> str:
        gains, reached = self.pid, self.margins
        return (
            f"kp {gains.kp:.6g}, ki {gains.ki:.6g}, kr {gains.kr:.6g}: "
            f"|S| ≤ {reached.sensitivity_peak:.4g} at {reached.sensitivity_peak_hz:.4g} Hz, "
            f"|T| ≤ {reached.complementary_peak:.4g} at {reached.complementary_peak_hz:.4g} Hz, "
            f"crossover {reached.crossover_hz:.4g} Hz"
        )


def tune_pid(
    plant: Any,
    *,
    max_sensitivity: float = 1.6,
    max_complementary: float = 1.6,
    derivative_filter: float = 0.0,
    filters: Sequence[Any] = (),
    sample_time: float | None = None,
    delay: float = 0.0,
    discretisation: Discretisation = "tustin",
) -> TunedPID:
    """Return the PID with the largest integral gain under bounds on the peaks of S and T.

        maximise ki   subject to   |S(jω)| ≤ M_s,  |T(jω)| ≤ M_t  at all ω,

    with S = 1/(1 + L), T = L/(1 + L) and L = k·G. A large ki brings a torque disturbance back
    soonest: the integral of the error after a step d is d/ki.

    Parameters
    ----------
    plant : Inertia, FlexibleInertia, Axis, python-control system or MeasuredResponse
        Its friction, torque limit and resolution are left out. A measured plant (frequency
        response data are taken for one) is looked at between its first and its last line; it has
        its delay in it, and the controller runs at its sample time.
    max_sensitivity, max_complementary : float, optional
        M_s and M_t, above 1. 1.4 is robust, 2 brisk; M_s gives a gain margin of M_s/(M_s − 1) and
        a phase margin of 2·asin(1/(2·M_s)) at least. Give both: M_s alone leaves a large M_t.
    derivative_filter : float, optional
        Time constant of the filter of the error's rate.
    filters : sequence, optional
        Notch, LeadLag, LowPass or any python-control system behind the PID. On a collocated mode
        a notch costs more than it gives: compare the two.
    sample_time : float, optional
        Of a digital controller. Default: continuous.
    delay : float, optional
        Computing delay of a digital controller, pure delay of a continuous one, ≥ 0.
    discretisation : "tustin", "matched" or "hold", optional
        Of a digital controller's filters, as in `Controller`.

    Returns
    -------
    TunedPID
        Both peaks are kept to 1e-5, by `loop_margins`, which has them between all points.

    Raises
    ------
    ValueError
        For a bound that is not above 1; where no start that keeps the bounds is found: it says
        what came nearest; or where nothing limits the gain.

    Notes
    -----
    A linear program for each step, each inside what is allowed: the loop stays stable. The
    maximum is a local one, the same from every start that was tried.

    References
    ----------
    Hast, Åström, Bernhardsson and Boyd, "PID design by convex-concave optimization", European
    Control Conference 2013.

    Examples
    --------
    >>> from jounce.plant import FlexibleInertia
    >>> axis = FlexibleInertia(2.0, frequency_hz=20.0, damping=0.01, load_fraction=0.4)
    >>> tuned = tune_pid(axis, sample_time=1e-3, delay=1e-3)
    >>> round(tuned.margins.sensitivity_peak, 4), round(tuned.margins.complementary_peak, 4)
    (1.6, 1.6)
    """
    around = circles(
        _above_one("max_sensitivity", max_sensitivity),
        _above_one("max_complementary", max_complementary),
    )
    if isinstance(plant, MeasuredResponse) or is_frd(plant):
        plant = _measured_plant(plant, delay)
        sample_time = plant.dt if sample_time is None else sample_time
    digital = sample_time is not None
    controller = Controller(
        PID(1.0, 1.0, 1.0, derivative_filter=derivative_filter),
        filters=filters,
        sample_time=sample_time,
        delay=delay if digital else 0.0,
        discretisation=discretisation,
    )
    loop: OpenGains | MeasuredGains
    if isinstance(plant, MeasuredResponse):
        loop = MeasuredGains(plant, controller)
        omega = loop.omega()
    else:
        loop = OpenGains(plant, controller, 0.0 if digital else pure_delay(delay))
        omega = frequency_points(loop.system(np.ones(3)), loop.delay)
    gains = _start(loop, omega, around)
    return _tuned(loop, omega, gains, around)


def _measured_plant(plant: Any, delay: float) -> MeasuredResponse:
    """Return a measured plant; ValueError for what is not one, or with a delay besides."""
    if finite("delay", delay):
        raise ValueError(
            f"delay = {shown(delay)} of a measured plant, which has its delay in it: leave it out"
        )
    measured = as_measured(plant, plant=True)
    if measured.kind != "plant":
        raise ValueError(
            f"kind = {measured.kind!r}: expected a response of the plant; take out the controller "
            "that it was measured with by plant_response(frf, controller)"
        )
    return measured


def _margins(loop: OpenGains | MeasuredGains, gains: Real) -> LoopMargins | MeasuredMargins:
    if isinstance(loop, MeasuredGains):
        return loop.margins(gains)
    margins: LoopMargins = loop_margins(loop.system(gains), delay=loop.delay)
    return margins


def _above_one(name: str, bound: float) -> float:
    number = finite(name, bound)
    if not number > 1.0:
        raise ValueError(
            f"{name} = {shown(bound)}: expected a number above 1, as a loop with integral action "
            "cannot keep below it at all frequencies; try 1.6"
        )
    return number


def _start(loop: OpenGains | MeasuredGains, omega: Real, around: tuple[Circle, ...]) -> Real:
    """Return gains that keep the bounds, of a stable loop: the largest ki that is tried."""
    terms = loop.terms(omega)
    double = abs(terms[:, 2]) * omega  # |k|·ω² of G = 1/(J·s²): constant over ω
    tried: list[tuple[float, Real]] = []
    for center, weight in zip(omega[::10], double[::10], strict=True):
        for p, i in _SHAPES:
            gains: Real = np.array([p * center, i * center**2, 1.0]) * center / weight
            tried.append((clearance(terms @ gains, around), gains))
    kept = sorted((found for found in tried if found[0] >= 0.0), key=lambda f: -f[1][1])
    for _, gains in kept[:: 1 + len(kept) // _MOST_STARTS]:
        if _margins(loop, gains).stable:
            return gains
    nearest = max(tried, key=lambda found: found[0])[1]
    raise _unreachable(loop, nearest)


def _unreachable(loop: OpenGains | MeasuredGains, nearest: Real) -> ValueError:
    margins = _margins(loop, nearest)
    reached = (
        f"the nearest has |S| up to {margins.sensitivity_peak:.3g} and |T| up to "
        f"{margins.complementary_peak:.3g}"
        if margins.stable
        else "those that come near are unstable"
    )
    return ValueError(
        "no PID that keeps the bounds was found between 1e-3 and 1e3 times the plant's own "
        f"frequencies: {reached}; allow larger peaks, take delay away, or give filters "
        "(a notch at a mode that the load's sensor sees)"
    )


def _tuned(
    loop: OpenGains | MeasuredGains, omega: Real, gains: Real, around: tuple[Circle, ...]
) -> TunedPID:
    """Return the optimum, the grid refined where a peak passes its bound between the points."""
    programs = 0
    for _ in range(_ROUNDS):
        found = largest_integral_gain(loop.terms(omega), gains, around)
        programs += found.programs
        if not found.at_rest:
            raise ValueError(
                "nothing limits the integral gain: the model lags by less than half a turn at all "
                "high frequencies; give delay=…, sample_time=… or derivative_filter=…"
            )
        margins = _margins(loop, found.gains)
        passed = _passed(margins, around)
        if margins.stable and not passed:
            return TunedPID(loop.with_gains(found.gains), margins, programs)
        omega = np.sort(np.concatenate([omega, *(_beside(place) for place in passed)]))
        gains = _back_inside(loop.terms(omega), gains, found.gains, around)
    if not margins.stable:
        raise ValueError(
            f"no stable loop was found at the largest integral gain with |S| ≤ "
            f"{1.0 / around[0].radius:.6g} and |T| ≤ {around[1].center / around[1].radius:.6g} "
            "between the frequencies looked at; allow larger peaks"
        )
    raise ValueError(
        f"a resonance at {margins.sensitivity_peak_hz:.4g} Hz is too sharp for the bounds to be "
        "kept on both sides of it; give the modes of the model the damping that they have, "
        "0.01 % or more"
    )


def _passed(margins: LoopMargins | MeasuredMargins, around: tuple[Circle, ...]) -> list[float]:
    """Return where, in rad/s, a peak is larger than its bound."""
    bounds = (1.0 / around[0].radius, around[1].center / around[1].radius)
    peaks = (
        (margins.sensitivity_peak, margins.sensitivity_peak_hz),
        (margins.complementary_peak, margins.complementary_peak_hz),
    )
    return [
        2.0 * pi * hz
        for bound, (peak, hz) in zip(bounds, peaks, strict=True)
        if peak > bound * (1.0 + _EXCESS)
    ]


def _beside(place: float) -> Real:
    """Return places around a peak, as far as the next points of a grid and then some."""
    return np.asarray(place * (1.0 + np.concatenate([0.03 * _AROUND, 1e-4 * _AROUND])))


def _back_inside(terms: Complex, before: Real, after: Real, around: tuple[Circle, ...]) -> Real:
    """Return gains between a start that keeps the bounds and an end that nearly does."""
    share = 1.0
    while share > 1e-6:
        gains = before + share * (after - before)
        if clearance(terms @ gains, around) >= 0.0:
            return gains
        share *= 0.5
    return before
