"""The survey of a measured loop: its margins with error bars, and what is required of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, isnan
from typing import Any

from ..shaping.drawing import draw
from ..shaping.frozen import Frozen
from ..shaping.told import Told
from .measured import MeasuredMargins, MeasuredResponse, as_measured, measured_margins
from .requirement_checks import OF_MARGINS, RequirementCheck, requirement_checks
from .specification import Labels, Requirement
from .unstable_loop import UnstableLoopError


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MeasuredSurvey(Told, Frozen):
    """What a measured loop shows without a model of it: no time responses.

    Attributes
    ----------
    measured : MeasuredResponse
    controller : Controller, PID, CascadedPI or None
        None where it is in what was measured.
    margins : MeasuredMargins
        Of a loop that is stable, or whose stability cannot be told.
    requirements : tuple of RequirementCheck
        Of margins.
    labels : Labels
    """

    measured: MeasuredResponse
    controller: Any
    margins: MeasuredMargins
    requirements: tuple[RequirementCheck, ...] = ()
    labels: Labels = field(default_factory=Labels)

    @property
    def findings(self) -> tuple[str, ...]:
        """Plain sentences on what is not met, and why stability cannot be told."""
        return (*self.untold, *self.unmet)

    @property
    def untold(self) -> tuple[str, ...]:
        """Sentences on what is asked and cannot be told: stability, required margins."""
        why = "; ".join(self.margins.reasons)
        stability = (f"Stability cannot be told: {why}.",) if self.margins.stable is None else ()
        return stability + tuple(
            f"Required {check.requirement.name} was not measured: no line shows it."
            for check in self.requirements
            if isnan(check.achieved)
        )

    @property
    def unmet(self) -> tuple[str, ...]:
        """A sentence on each requirement that is not met."""
        missed = (check for check in self.requirements if check.missed_by < inf)
        return tuple(check.sentence(self.labels) for check in missed if not check.met)

    @property
    def notes(self) -> tuple[str, ...]:
        """What else a reader of the margins has to know."""
        return self.margins.warnings

    @property
    def heading(self) -> tuple[str, ...]:
        """The lines above the tables."""
        return (self.labels.title,) if self.labels.title else ()

    def page(self) -> tuple[Any, ...]:
        """Return what is printed: heading, tables (of rich) and lines, notes and findings."""
        from .measured_tables import margins_report
        from .requirement_table import requirements_table

        tables = requirements_table(self.requirements, self.labels)
        measured = margins_report(self.measured, self.margins)
        return (*self.heading, *tables, *measured, *self.notes, *self.findings)

    def __str__(self) -> str:
        """Return the page as text, as wide as the terminal, else 160 characters."""
        from .tables import as_text

        return as_text(self.page())

    def sigma_of(self, check: RequirementCheck) -> float:
        """Return the standard deviation of a required margin, 0 where there is none."""
        found = float(getattr(self.margins, f"{OF_MARGINS[check.requirement.name]}_sigma"))
        return 0.0 if isnan(found) else found

    def plot(self) -> Any:
        """Draw it by `jounce.plots`: L, Nyquist, S and T with bands."""
        return draw(self)


def measured_survey(
    measured: MeasuredResponse,
    controller: Any = None,
    *,
    requirements: Sequence[Requirement] = (),
    labels: Labels | None = None,
) -> MeasuredSurvey:
    """Survey a measured loop, or a measured plant under a controller.

    Parameters
    ----------
    measured : MeasuredResponse
    controller : Controller, PID, CascadedPI or python-control system, optional
        Needed with a plant and with PS, refused with the others.
    requirements : sequence of Requirement, optional
        Bounds on margins.
    labels : Labels, optional
        How the results are told. Default: without a title, in rad.

    Returns
    -------
    MeasuredSurvey

    Raises
    ------
    UnstableLoopError
        Where the closed loop is unstable for sure.
    ValueError
        As `measured_margins` does.
    """
    for asked in requirements:
        if asked.name not in OF_MARGINS:
            raise ValueError(
                f"requirement {asked.name!r}: a measured loop has margins alone, "
                f"{', '.join(OF_MARGINS)}; fit an axis by analysis.fit_axis for the rest"
            )
    measured = as_measured(measured, plant=controller is not None)
    margins = measured_margins(measured, controller)
    if margins.stable is False:
        reason = margins.reasons[0].removeprefix("unstable: ")
        raise UnstableLoopError(
            f"the measured loop is UNSTABLE: {reason}; there are no margins to report. Change the "
            "gains"
        )
    found = MeasuredSurvey(
        measured=measured, controller=controller, margins=margins, labels=labels or Labels()
    )
    return replace(found, requirements=requirement_checks(found, requirements))
