"""Measured frequency responses: reading, estimating, margins with error bars, models."""

from .conversions import ClosedResponses, closed_responses, open_loop, plant_response
from .estimating import EstimatedFRF, estimate_frf
from .excitation import Multisine, multisine
from .margins_of_data import measured_margins
from .measured_response import MeasuredResponse, is_frd
from .reading import read_frf
from .result import MeasuredMargins

__all__ = [
    "ClosedResponses",
    "EstimatedFRF",
    "MeasuredMargins",
    "MeasuredResponse",
    "Multisine",
    "closed_responses",
    "estimate_frf",
    "is_frd",
    "measured_margins",
    "multisine",
    "open_loop",
    "plant_response",
    "read_frf",
]
