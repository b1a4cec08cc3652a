"""Measured frequency responses: reading, estimating, margins with error bars, models."""

from .conversions import ClosedResponses, closed_responses, open_loop, plant_response
from .estimating import EstimatedFRF, estimate_frf
from .excitation import Multisine, multisine
from .low_order import FittedAxis, fit_axis
from .margins_of_data import measured_margins
from .measured_response import MeasuredResponse, is_frd
from .reading import read_frf
from .repeated import RepeatedMargins, repeated_margins
from .result import MeasuredMargins

__all__ = [
    "ClosedResponses",
    "EstimatedFRF",
    "FittedAxis",
    "MeasuredMargins",
    "MeasuredResponse",
    "Multisine",
    "RepeatedMargins",
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
