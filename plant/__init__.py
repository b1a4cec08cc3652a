"""Plants, controllers and loops as python-control systems, and their exact responses."""

from typing import TYPE_CHECKING

from ..later import later

if TYPE_CHECKING:
    from .anti_windup import BackCalculation, Clamp
    from .axis import Axis, as_axis, chain_axis, system_axis
    from .cascade import CascadedPI
    from .closed_systems import Sensitivity
    from .commands import Ramp, Sine
    from .controller import Controller, as_controller
    from .deviations import LoopDeviations
    from .disturbances import SampledTorque, TorqueSine, TorqueSteps, Wind
    from .exact_response import respond
    from .feedforward import Feedforward, InertiaFeedforward
    from .filters import LeadLag, LowPass, Notch
    from .flexible_inertia import FlexibleInertia
    from .flexible_mode import FlexibleMode
    from .friction import Friction
    from .inertia import Inertia
    from .inverse import inverse_feedforward, low_frequency_feedforward
    from .loop_response import LoopResponse
    from .many import respond_all
    from .pid import PID
    from .pid_design import design_pid
    from .realisation import noise_realisation, wind_realisation
    from .ripple import Ripple
    from .sampled import zero_order_hold
    from .servo_loop import ServoLoop
    from .shaper_systems import filter_system
    from .spectrum import Spectrum

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "Axis": "axis",
    "BackCalculation": "anti_windup",
    "CascadedPI": "cascade",
    "Clamp": "anti_windup",
    "Controller": "controller",
    "Feedforward": "feedforward",
    "FlexibleInertia": "flexible_inertia",
    "FlexibleMode": "flexible_mode",
    "Friction": "friction",
    "Inertia": "inertia",
    "InertiaFeedforward": "feedforward",
    "LeadLag": "filters",
    "LoopDeviations": "deviations",
    "LoopResponse": "loop_response",
    "LowPass": "filters",
    "Notch": "filters",
    "PID": "pid",
    "Ramp": "commands",
    "Ripple": "ripple",
    "SampledTorque": "disturbances",
    "Sensitivity": "closed_systems",
    "ServoLoop": "servo_loop",
    "Sine": "commands",
    "Spectrum": "spectrum",
    "TorqueSine": "disturbances",
    "TorqueSteps": "disturbances",
    "Wind": "disturbances",
    "as_axis": "axis",
    "as_controller": "controller",
    "chain_axis": "axis",
    "design_pid": "pid_design",
    "filter_system": "shaper_systems",
    "inverse_feedforward": "inverse",
    "low_frequency_feedforward": "inverse",
    "noise_realisation": "realisation",
    "respond": "exact_response",
    "respond_all": "many",
    "system_axis": "axis",
    "wind_realisation": "realisation",
    "zero_order_hold": "sampled",
}

__all__ = [
    "PID",
    "Axis",
    "BackCalculation",
    "CascadedPI",
    "Clamp",
    "Controller",
    "Feedforward",
    "FlexibleInertia",
    "FlexibleMode",
    "Friction",
    "Inertia",
    "InertiaFeedforward",
    "LeadLag",
    "LoopDeviations",
    "LoopResponse",
    "LowPass",
    "Notch",
    "Ramp",
    "Ripple",
    "SampledTorque",
    "Sensitivity",
    "ServoLoop",
    "Sine",
    "Spectrum",
    "TorqueSine",
    "TorqueSteps",
    "Wind",
    "as_axis",
    "as_controller",
    "chain_axis",
    "design_pid",
    "filter_system",
    "inverse_feedforward",
    "low_frequency_feedforward",
    "noise_realisation",
    "respond",
    "respond_all",
    "system_axis",
    "wind_realisation",
    "zero_order_hold",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
