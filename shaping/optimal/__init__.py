"""Minimum time at any order: motions by linear programming, and proofs of how good they are."""

from .binding import binding_limits
from .certificate import Certificate, certify, proven_excess

__all__ = ["Certificate", "binding_limits", "certify", "proven_excess"]
