"""The whole controller: its law, filters behind it, and how a processor runs it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..shaping.checks import finite, of_kind, one_of, positive
from ..shaping.frozen import Frozen
from ..shaping.pieces import FloatArray
from ..shaping.real_numbers import shown
from .anti_windup import BackCalculation, Clamp
from .cascade import CascadedPI
from .discretise import Discretisation, Element, checked_filters, filter_system_of, sections
from .linear_system import linear_system
from .models import StateModel
from .pid import PID

if TYPE_CHECKING:
    import control

AntiWindup = Literal["conditional"] | BackCalculation | Clamp


@dataclass(frozen=True)
class Controller(Frozen):
    """A control law with filters behind it, continuous or run once a sample.

    In sample k, at t_k = k·sample_time, a digital one takes the measured position y_k and

        PID:     D_k = (T_f·D_{k−1} + e_k − e_{k−1})/(T_f + T),  I_k = I_{k−1} + T·e_k,
                 w_k = kp·e_k + ki·I_k + kr·D_k,
        P-PI:    v_k = (T_f·v_{k−1} + y_k − y_{k−1})/(T_f + T),  ε_k = kv·e_k + fv·ṙ_k − v_k,
                 I_k = I_{k−1} + T·ε_k,  w_k = Kp·ε_k + (Kp/T_n)·I_k,

    then the filters, then adds the feedforward, limits the torque to u_k, and takes care of the
    integral. u_k acts from t_k + delay on, until the next one does.

    Parameters
    ----------
    law : PID or CascadedPI
    filters : sequence, optional
        Notch, LeadLag, LowPass, or any python-control system; in the order of the signal.
    sample_time : float, optional
        Positive. Default: continuous.
    delay : float, optional
        Computing delay ≥ 0 of any length; needs a sample time.
    anti_windup : "conditional", BackCalculation or Clamp, optional
        "conditional" undoes an integration that would drive the torque further beyond its limit.
        Default: none.
    discretisation : "tustin", "matched" or "hold", optional
        Of the filters; Tustin's is prewarped at each filter's own frequency. Above 0.8 of the
        Nyquist frequency (a notch on "hold" above 0.1) a filter is warned of.

    Raises
    ------
    ValueError
        For a delay without sample time, a filter at or above the Nyquist frequency, or a value
        out of range.

    Examples
    --------
    >>> digital = Controller(PID(2.0, 1.0, 3.0), sample_time=1e-3, delay=0.4e-3)
    >>> digital.sampled().dt
    0.001
    """

    law: PID | CascadedPI
    _: KW_ONLY
    filters: Sequence[Element] = ()
    sample_time: float | None = None
    delay: float = 0.0
    anti_windup: AntiWindup | None = None
    discretisation: Discretisation = "tustin"

    def __post_init__(self) -> None:
        if not isinstance(self.law, PID | CascadedPI):
            raise TypeError(f"law = {shown(self.law)}: expected PID or CascadedPI")
        if self.sample_time is not None:
            object.__setattr__(self, "sample_time", positive("sample_time", self.sample_time))
        object.__setattr__(self, "delay", finite("delay", self.delay))
        if self.delay < 0.0:
            raise ValueError(f"delay = {shown(self.delay)}: expected a time ≥ 0")
        if self.delay > 0.0 and self.sample_time is None:
            raise ValueError(
                f"delay = {shown(self.delay)} without a sample time: a continuous "
                "controller computes "
                "at once; give sample_time=… as well"
            )
        one_of("discretisation", self.discretisation, ("tustin", "matched", "hold"))
        filters = checked_filters(self.filters, self.sample_time, self.discretisation)
        object.__setattr__(self, "filters", filters)
        if isinstance(self.anti_windup, str):
            one_of("anti_windup", self.anti_windup, ("conditional", "none"))
        elif self.anti_windup is not None:
            kinds = "'conditional', BackCalculation(…), Clamp(…) or None"
            of_kind("anti_windup", self.anti_windup, BackCalculation | Clamp, kinds)  # type: ignore[arg-type]
        self._check_tracking()

    def _check_tracking(self) -> None:
        way, dt = self.anti_windup, self.sample_time or 0.0
        if isinstance(way, BackCalculation) and way.tracking_time < 0.5 * dt:
            raise ValueError(
                f"tracking_time = {shown(way.tracking_time)}: below half a sample the "
                "limited loop's "
                f"integral is unstable; give {0.5 * dt:g} or more"
            )

    @property
    def integral_gain(self) -> float:
        """Torque per integral."""
        return self.law.ki if isinstance(self.law, PID) else self.law.integral_gain

    @property
    def standing_gain(self) -> float:
        """How fast the torque grows per error that stays: the integral's, behind the filters."""
        error = self.law.position_gain if isinstance(self.law, CascadedPI) else 1.0
        return self.integral_gain * error * self.filter_gain

    @property
    def filter_gain(self) -> float:
        """What the filters make of a constant."""
        gains = [filter_system_of(f).dcgain(warn_infinite=False) for f in self.filters]
        return float(np.prod(gains))

    @property
    def rate_filter(self) -> float:
        """Time constant of the filter of the error's rate, or of the velocity."""
        law = self.law
        return law.derivative_filter if isinstance(law, PID) else law.velocity_filter

    @cached_property
    def sections(self) -> FloatArray:
        """The filters as sections (b0, b1, b2, a1, a2) run once a sample, (m, 5)."""
        return sections(self.filters, self._dt, self.discretisation)

    def transfer(self) -> control.TransferFunction:
        """Return k(s) from e to u of a continuous one (improper, where the law is)."""
        import control

        if self.sample_time is not None:
            raise ValueError(
                f"a controller with sample_time = {shown(self.sample_time)} has no k(s): "
                "use sampled()"
            )
        whole = self.law.transfer()
        for element in self.filters:
            whole = control.tf(filter_system_of(element)) * whole
        return control.tf(whole, inputs=["e"], outputs=["u_feedback"], name="controller")

    def sampled(self) -> control.StateSpace:
        """Return what a digital one does once a sample, without limit, (e, e_motor) → u_feedback.

        e is the error of the measured position, e_motor that of what the velocity is taken from;
        with one encoder both are one, and their sum of columns is k(z). For a P-PI the command
        stands still. The delay is left out.
        """
        model = self.sampled_model()
        return linear_system(
            (model.A, model.B, model.C, model.D),
            model.dt,
            inputs=["e", "e_motor"],
            outputs=["u_feedback"],
            states=[f"x_{i}" for i in range(model.nstates)],
            name="controller",
        )

    def sampled_model(self) -> StateModel:
        """Return the numbers of `sampled`."""
        return self._sampled_model

    @cached_property
    def _sampled_model(self) -> StateModel:
        whole = _law(self.law, self._dt)
        for row in self.sections:
            whole = _section(row, self._dt).behind(whole)
        return whole

    @cached_property
    def memory_places(self) -> tuple[Any, FloatArray]:
        """Where `memory_at_rest` has the states of `sampled_model`, and the sign that they take.

        The model is fed with errors of the position and not with the position's own; of a cascade
        the motor's rate is that of the position.
        """
        law = 1 + np.flatnonzero(_whole_law(self.law, self._dt).C[0])
        turned = -np.ones(4 + 2 * len(self.sections))
        if isinstance(self.law, CascadedPI):
            turned[2:4] = 1.0
        places = np.append(law, np.arange(4, len(turned)))
        return places, turned[places]

    @property
    def _dt(self) -> float:
        if self.sample_time is None:
            raise ValueError("a continuous controller has no samples: give sample_time=…")
        return self.sample_time


def as_controller(controller: Any) -> Controller:
    """Return a Controller: itself, or a law without filters, continuous.

    Parameters
    ----------
    controller : Controller, PID or CascadedPI

    Returns
    -------
    Controller
        Torque per error in the law's own units.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(controller, Controller):
        return controller
    if isinstance(controller, PID | CascadedPI):
        return Controller(controller)
    raise TypeError(
        f"controller = {shown(controller)}: expected PID, CascadedPI or Controller(law, …)"
    )


def _law(law: PID | CascadedPI, dt: float) -> StateModel:
    """Return the sampled law without the states that do nothing.

    An integral without gain would count as unstable.
    """
    whole = _whole_law(law, dt)
    used = whole.C[0] != 0.0
    return StateModel(whole.A[np.ix_(used, used)], whole.B[used], whole.C[:, used], whole.D, dt)


def _whole_law(law: PID | CascadedPI, dt: float) -> StateModel:
    """Return the sampled law with states I, e_motor before, and the filtered rate before."""
    lag = law.derivative_filter if isinstance(law, PID) else law.velocity_filter
    kept, slope = lag / (lag + dt), 1.0 / (lag + dt)
    rate = np.array([0.0, -slope, kept])  # of the states; + slope·e_motor
    if isinstance(law, PID):
        a = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], rate])
        b = np.array([[dt, 0.0], [0.0, 1.0], [0.0, slope]])
        c = law.ki * a[:1] + law.kr * rate
        d = np.array([[law.kp + law.ki * dt, law.kr * slope]])
    else:
        within = np.array([law.position_gain, slope])  # ε of e and e_motor; + rate of the states
        a = np.array([np.array([1.0, 0.0, 0.0]) + dt * rate, [0.0, 0.0, 0.0], rate])
        b = np.array([dt * within, [0.0, 1.0], [0.0, slope]])
        c = law.velocity_gain * rate[None] + law.integral_gain * a[:1]
        d = (law.velocity_gain + law.integral_gain * dt) * within[None]
    return StateModel(a, b, c, d, dt)


def _section(row: FloatArray, dt: float) -> StateModel:
    """Return a section in state space, transposed direct form II."""
    b0, b1, b2, a1, a2 = row
    a = np.array([[-a1, 1.0], [-a2, 0.0]])
    b = np.array([[b1 - a1 * b0], [b2 - a2 * b0]])
    return StateModel(a, b, np.array([[1.0, 0.0]]), np.array([[b0]]), dt)
