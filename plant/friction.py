"""Dry friction: Coulomb's, with stiction."""

from __future__ import annotations

from dataclasses import dataclass

from ..shaping.checks import finite
from ..shaping.real_numbers import shown


@dataclass(frozen=True)
class Friction:
    """Dry friction on the motor: it sticks, or slides against a constant torque.

    Sliding, the friction's torque is −coulomb·sign(velocity). At velocity 0 the motor sticks as
    long as the torque that this needs is at most `static`, and breaks away beyond it.

    Parameters
    ----------
    coulomb : float
        Torque (or force) while it slides, ≥ 0.
    static : float, optional
        Largest torque while it sticks, ≥ coulomb. Default: `coulomb`.

    Examples
    --------
    >>> Friction(3.0)
    Friction(coulomb=3.0, static=3.0)
    """

    coulomb: float
    static: float | None = None

    def __post_init__(self) -> None:
        coulomb = finite("coulomb", self.coulomb)
        if coulomb < 0.0:
            raise ValueError(f"coulomb = {shown(self.coulomb)}: expected a torque ≥ 0")
        static = coulomb if self.static is None else finite("static", self.static)
        if static < coulomb:
            raise ValueError(
                f"static = {shown(self.static)}: expected at least coulomb = "
                f"{shown(self.coulomb)}; leave "
                "it out where the two are equal"
            )
        object.__setattr__(self, "coulomb", coulomb)
        object.__setattr__(self, "static", static)

    @property
    def holds(self) -> float:
        """Largest torque while it sticks."""
        return self.coulomb if self.static is None else self.static
