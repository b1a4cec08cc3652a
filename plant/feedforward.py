"""Feedforward: the torque, and the shift of position, that derivatives of the command need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shaping.checks import finite, of_kind, whole
from ..shaping.derivatives import derivative_name, derivative_number
from ..shaping.frozen import Frozen
from ..shaping.pieces import MAX_ORDER, FloatArray
from ..shaping.real_numbers import shown
from .inverse_dynamics import InverseDynamics
from .linear_system import static_gain

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class InertiaFeedforward:
    """Feedforward u = Ĵ·r̈, f(s) = Ĵ·s², fed by the shaper's own acceleration.

    Parameters
    ----------
    J_hat : float
        Estimate Ĵ of the inertia; 0 for none.
    """

    J_hat: float

    def __post_init__(self) -> None:
        estimate = finite("J_hat", self.J_hat)
        if estimate < 0.0:
            raise ValueError(f"J_hat = {shown(self.J_hat)}: expected a number ≥ 0")
        object.__setattr__(self, "J_hat", estimate)

    def system(self) -> control.StateSpace:
        """Return the python-control system r_acceleration → u_feedforward (a gain)."""
        return static_gain(
            [[self.J_hat]],
            inputs=["r_acceleration"],
            outputs=["u_feedforward"],
            name="feedforward",
        )

    def transfer(self) -> control.TransferFunction:
        """Return f(s) = Ĵ·s² from r to u (improper)."""
        import control

        f = [self.J_hat, 0.0, 0.0]
        return control.tf(f, [1.0], inputs=["r"], outputs=["u_feedforward"], name="feedforward")


def _nothing() -> Mapping[int, float]:
    return MappingProxyType({})


@dataclass(frozen=True)
class Feedforward(Frozen):
    """Feedforward of any derivatives of the command r.

        u_feedforward = Σ_k torque[k]·r^(k) + friction·sign(ṙ),
        e = r + Σ_k position[k]·r^(k) − y,

    to both of which `dynamics` may add.

    Parameters
    ----------
    torque : mapping from int or str to float, optional
        By derivative, number or name: {"velocity": B, "acceleration": J, "snap": s}, which is
        {1: B, 2: J, 4: s}.
    position : mapping from int or str to float, optional
        What a flexible axis's motor has to be ahead of the load, {2: q}.
    friction : float, optional
        Torque ≥ 0 in the direction of the command; 0 where the command stands still. More than
        the axis's own Coulomb friction makes a limit cycle.
    lead : float, optional
        Time by which a digital controller's torque feedforward looks ahead, ≥ 0. What makes up
        for a delay τ and the hold is τ + sample_time/2.
    dynamics : InverseDynamics, optional
        What the exact inverse of a damped axis remembers of the command, as `inverse_feedforward`
        finds it.

    Examples
    --------
    >>> Feedforward({1: 0.5, "acceleration": 2.0}).order
    2
    """

    torque: Mapping[int, float] = field(default_factory=_nothing)
    _: KW_ONLY
    position: Mapping[int, float] = field(default_factory=_nothing)
    friction: float = 0.0
    lead: float = 0.0
    dynamics: InverseDynamics | None = None

    def __post_init__(self) -> None:
        for name in ("torque", "position"):
            object.__setattr__(self, name, _gains(name, getattr(self, name)))
        for name in ("friction", "lead"):
            value = finite(name, getattr(self, name))
            if value < 0.0:
                raise ValueError(f"{name} = {shown(value)}: expected a number ≥ 0")
            object.__setattr__(self, name, value)
        if self.dynamics is not None:
            kind = "InverseDynamics(…), as inverse_feedforward(axis) finds it"
            of_kind("dynamics", self.dynamics, InverseDynamics, kind)

    def __hash__(self) -> int:
        kept = (self.torque.items(), self.position.items())
        return hash((*map(frozenset, kept), self.friction, self.lead, self.dynamics))

    @property
    def order(self) -> int:
        """Highest derivative of the command that must be finite."""
        remembered = 0 if self.dynamics is None else self.dynamics.derivative
        return max([0, *self.torque, *self.position, remembered])

    def within(self, order: int) -> Feedforward:
        """Return it without the derivatives above an order, of which a command has impulses."""
        torque = {k: gain for k, gain in self.torque.items() if k <= order}
        position = {k: gain for k, gain in self.position.items() if k < order}  # its rate is taken
        kept = self.dynamics if self.order <= order else None
        return replace(self, torque=torque, position=position, dynamics=kept)

    def requirement(self, command: Any = None) -> str:
        """Return, in one line, what it asks of the command, and what a given one lacks.

        Examples
        --------
        >>> print(Feedforward({"acceleration": 2.0, "snap": 0.1}).requirement())
        needs snap of the command bounded (limits of order 4, order 5 for a continuous torque)
        """
        n = self.order
        if n == 0:
            return "needs nothing of the command"
        told = (
            f"needs {derivative_name(n)} of the command bounded (limits of order {n}, order "
            f"{n + 1} for a continuous torque)"
        )
        if command is None:
            return told
        from .commands import command_order

        given = command_order(command)
        if given >= n:
            return f"{told}: the command is of order {given}" if given < MAX_ORDER else told
        return (
            f"{told}: the command is of order {given}, so its {derivative_name(given + 1)} is a "
            "train of impulses that cannot be fed forward"
        )

    def torque_gains(self, highest: int) -> FloatArray:
        """Return torque per derivative 0 … highest."""
        return np.array([self.torque.get(k, 0.0) for k in range(highest + 1)])

    def position_gains(self, highest: int) -> FloatArray:
        """Return the reference's gain of derivatives 0 … highest, that of the command 1."""
        gains = np.array([self.position.get(k, 0.0) for k in range(highest + 1)])
        gains[0] += 1.0
        return gains

    def transfer(self) -> control.TransferFunction:
        """Return f(s) = Σ torque[k]·s^k, and what its dynamics add, from r to u (improper)."""
        import control

        f = self.torque_gains(self.order)[::-1]
        below: tuple[float, ...] = (1.0,)
        if self.dynamics is not None:
            below = self.dynamics.denominator[::-1]
            own = [*self.dynamics.torque[::-1], *[0.0] * self.dynamics.derivative]
            f = np.polyadd(np.polymul(f, below), own)
        return control.tf(f, below, inputs=["r"], outputs=["u_feedforward"], name="feedforward")


def as_feedforward(feedforward: Any) -> Feedforward:
    """Return any feedforward, or none, as a Feedforward."""
    if feedforward is None:
        return Feedforward()
    if isinstance(feedforward, InertiaFeedforward):
        return Feedforward({2: feedforward.J_hat} if feedforward.J_hat else {})
    if isinstance(feedforward, Feedforward):
        return feedforward
    raise TypeError(
        f"feedforward = {shown(feedforward)}: expected InertiaFeedforward, Feedforward or None"
    )


def _gains(name: str, given: Any) -> Mapping[int, float]:
    """Return gains by number of the derivative, in order, read-only."""
    if not isinstance(given, Mapping):
        raise TypeError(
            f"{name} = {shown(given)}: expected a mapping from derivatives to gains, such as "
            "{'acceleration': J}"
        )
    gains: dict[int, float] = {}
    for key, value in given.items():
        k = whole(name, derivative_number(key), 0 if name == "torque" else 1, MAX_ORDER)
        if k in gains:
            raise ValueError(f"{name} gives derivative {k} twice: once by number, once by name")
        gains[k] = finite(f"{name}[{key!r}]", value)
    return MappingProxyType(dict(sorted(gains.items())))
