"""The relaxed program of a grid: what it answers at a duration, and what its multipliers prove."""

from __future__ import annotations

from dataclasses import dataclass

from ...pieces import FloatArray
from .costate import Costate, Multipliers
from .elastic import Elastic, Found
from .relaxation import MeanRows
from .sampled import Sampled


@dataclass(frozen=True, eq=False)
class Relaxed:
    """An answer at a duration: its multipliers, and the polynomial that they make of the bounds."""

    means: MeanRows
    found: Found
    multipliers: Multipliers
    costate: Costate
    polynomial: FloatArray
    motion: Sampled


@dataclass(frozen=True, eq=False)
class RelaxedProgram:
    """The program of `MeanRows`, its inputs on the cells between the edges."""

    elastic: Elastic
    means: MeanRows
    edges: FloatArray

    def solve(self, time: float) -> Relaxed | None:
        """Return the answer at a duration; None where the solver fails."""
        found, problem = self.elastic.solve(time), self.elastic.problem
        if found is None:
            return None
        multipliers = self.means.multipliers(problem, found.ends, found.rows)
        costate = multipliers.costate()
        polynomial = multipliers.polynomial(problem, costate)
        motion = Sampled(self.edges, found.inputs, time)
        return Relaxed(self.means, found, multipliers, costate, polynomial, motion)
