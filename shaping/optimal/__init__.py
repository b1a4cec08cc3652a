"""Minimum time at any order: motions by linear programming, and proofs of how good they are."""

from typing import TYPE_CHECKING

from ...later import later

if TYPE_CHECKING:
    from .binding import binding_limits
    from .certificate import Certificate, certify, proven_excess

# Imported when they are first asked for: a certificate takes a solver of linear programs.
_LATER = {
    "Certificate": "certificate",
    "binding_limits": "binding",
    "certify": "certificate",
    "proven_excess": "certificate",
}

__all__ = ["Certificate", "binding_limits", "certify", "proven_excess"]

__getattr__, __dir__ = later(__name__, _LATER, __all__)
