"""Plants, controllers and loops as python-control systems, and their exact responses."""

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


def __dir__() -> list[str]:
    return sorted(__all__)
