"""Measured frequency responses: reading, estimating, margins with error bars, models."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .conversions import ClosedResponses, closed_responses, open_loop, plant_response
    from .estimating import EstimatedFRF, estimate_frf
    from .excitation import Multisine, multisine
    from .low_order import FittedAxis, fit_axis
    from .margins_of_data import measured_margins
    from .measured_response import MeasuredResponse, as_measured, is_frd
    from .reading import read_frf
    from .repeated import RepeatedMargins, repeated_margins
    from .result import MeasuredMargins

# Imported when they are first asked for, so that a command starts soon.
_LATER = {
    "ClosedResponses": "conversions",
    "EstimatedFRF": "estimating",
    "FittedAxis": "low_order",
    "MeasuredMargins": "result",
    "MeasuredResponse": "measured_response",
    "Multisine": "excitation",
    "RepeatedMargins": "repeated",
    "as_measured": "measured_response",
    "closed_responses": "conversions",
    "estimate_frf": "estimating",
    "fit_axis": "low_order",
    "is_frd": "measured_response",
    "measured_margins": "margins_of_data",
    "multisine": "excitation",
    "open_loop": "conversions",
    "plant_response": "conversions",
    "read_frf": "reading",
    "repeated_margins": "repeated",
}

__all__ = [
    "ClosedResponses",
    "EstimatedFRF",
    "FittedAxis",
    "MeasuredMargins",
    "MeasuredResponse",
    "Multisine",
    "RepeatedMargins",
    "as_measured",
    "closed_responses",
    "estimate_frf",
    "fit_axis",
    "is_frd",
    "measured_margins",
    "multisine",
    "open_loop",
    "plant_response",
    "read_frf",
    "repeated_margins",
]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
