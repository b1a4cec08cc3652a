"""The axis: what a servo drive moves, with its friction, limits and sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from math import inf, nan
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..shaping.checks import finite, of_kind, one_of, positive
from ..shaping.frozen import Frozen
from ..shaping.real_numbers import real_array, real_number, shown
from .dynamics import Dynamics, linear_dynamics, mechanical_dynamics
from .exact_response import refuse_data, state_space
from .flexible_inertia import FlexibleInertia
from .flexible_mode import FlexibleMode
from .friction import Friction
from .inertia import Inertia
from .linear_system import linear_system
from .mechanics import Mechanics, chain_mechanics, held_mechanics, modal_mechanics
from .models import StateModel
from .ripple import Ripple

if TYPE_CHECKING:
    import control

Sensor = Literal["motor", "load", "both"]


@dataclass(frozen=True)
class Axis(Frozen):
    """An axis that a drive moves: inertia, flexible modes, friction, torque limit and sensors.

    With M, C, K its matrices of mass, damping and stiffness and l the load's row,

        M·q̈ + C·q̇ + K·q = e_motor·(torque + friction + d_motor) + l·(constant_load + d_load),
        current_lag·torque′ = u − torque,   |u| ≤ torque_limit.

    Parameters
    ----------
    J : float
        Inertia (or mass) of the whole, positive.
    modes : sequence of FlexibleMode, optional
        All free-free, or all with the motor held. Default: rigid.
    viscous, load_viscous : float, optional
        Viscous friction of motor and load, torque per velocity, ≥ 0.
    spring : float, optional
        From the motor to the ground, torque per position, ≥ 0.
    sensor : "motor", "load" or "both", optional
        What is measured. With both, position is the load's and velocity the motor's.
    friction : Friction, optional
        Dry friction on the motor.
    torque_limit : float, optional
        Of the command u, positive. Default: none.
    current_lag : float, optional
        Time constant of the current loop, ≥ 0.
    encoder_step : float, optional
        Resolution, ≥ 0: a sample is a multiple of it, the nearest one.
    gear_ratio : float, optional
        Revolutions of the motor for one of the axis, positive. All that is said here is seen at
        the axis; it only tells motor torque and current of the drive.
    torque_constant : float, optional
        Torque at the motor's shaft per current, positive. Default: no current is told.
    constant_load : float, optional
        Torque that always acts on the load, in the direction of positive positions.
    ripple : Ripple, optional
        Torque on the motor over its position: cogging. In simulations, not in transfer functions.

    Raises
    ------
    ValueError
        For a value out of range, modes that do not fit together, or an axis that cannot hold its
        load.

    Examples
    --------
    >>> telescope = Axis(1000.0, modes=[FlexibleMode(9.0, 0.01, load_fraction=0.6)], viscous=20.0)
    >>> telescope.system().nstates
    4
    """

    J: float
    _: KW_ONLY
    modes: Sequence[FlexibleMode] = ()
    viscous: float = 0.0
    load_viscous: float = 0.0
    spring: float = 0.0
    sensor: Sensor = "motor"
    friction: Friction | None = None
    torque_limit: float = inf
    current_lag: float = 0.0
    encoder_step: float = 0.0
    gear_ratio: float = 1.0
    torque_constant: float | None = None
    constant_load: float = 0.0
    ripple: Ripple | None = None
    body: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.body, _System):
            object.__setattr__(self, "J", positive("J", self.J))
        for name in ("viscous", "load_viscous", "spring", "current_lag", "encoder_step"):
            value = finite(name, getattr(self, name))
            if value < 0.0:
                raise ValueError(f"{name} = {shown(value)}: expected a number ≥ 0")
            object.__setattr__(self, name, value)
        object.__setattr__(self, "modes", _modes(self.modes))
        one_of("sensor", self.sensor, ("motor", "load", "both"))
        if self.friction is not None:
            of_kind("friction", self.friction, Friction, "Friction(coulomb, static)")
        if self.ripple is not None:
            of_kind("ripple", self.ripple, Ripple, "Ripple(positions, torques, period)")
        self._check_drive()
        if self.friction is not None and not self._friction_moves():
            raise ValueError(
                "friction acts on a mass: give a system with exactly two poles more than zeros (a "
                "current loop belongs into current_lag), or leave the friction out"
            )

    def _check_drive(self) -> None:
        limit = real_number("torque_limit", self.torque_limit)
        if not limit > 0.0:
            raise ValueError(
                f"torque_limit = {shown(self.torque_limit)}: expected a positive torque"
            )
        object.__setattr__(self, "torque_limit", limit)
        object.__setattr__(self, "gear_ratio", positive("gear_ratio", self.gear_ratio))
        if self.torque_constant is not None:
            constant = positive("torque_constant", self.torque_constant)
            object.__setattr__(self, "torque_constant", constant)
        object.__setattr__(self, "constant_load", finite("constant_load", self.constant_load))
        if abs(self.constant_load) > limit:
            raise ValueError(
                f"torque_limit = {shown(limit)} cannot hold the constant_load = "
                f"{shown(self.constant_load)}: "
                "raise the limit above the load"
            )
        self._check_breakaway()

    def _check_breakaway(self) -> None:
        """Refuse a drive that never moves its axis, whichever way load and ripple help it."""
        helped = self.torque_limit + abs(self.constant_load)
        helped += 0.0 if self.ripple is None else float(np.abs(self.ripple.torques).max())
        if self.friction is not None and helped <= self.friction.holds:
            raise ValueError(
                f"torque_limit = {shown(self.torque_limit)} never overcomes the static friction of "
                f"{shown(self.friction.holds)}: raise the limit above it"
            )

    def _friction_moves(self) -> bool:
        dynamics = self.rigid_current
        return bool(dynamics.motor_rate @ dynamics.b[:, 0] > 0.0)

    @cached_property
    def rigid_current(self) -> Dynamics:
        """Equations of motion without the current loop's lag."""
        if isinstance(self.body, _System):
            return linear_dynamics(self.body.system)
        return mechanical_dynamics(self.mechanics)

    @cached_property
    def dynamics(self) -> Dynamics:
        """Equations of motion, the current loop's lag included."""
        return self.rigid_current.lagging(self.current_lag)

    @cached_property
    def mechanics(self) -> Mechanics:
        """Matrices of mass, damping and stiffness; not those of a `system_axis`."""
        if isinstance(self.body, _System):
            raise ValueError(
                "an axis given as a system has no matrices of mass and stiffness: give it as "
                "Axis(J, modes=…) or chain_axis(…)"
            )
        if self.body is not None:
            bare = chain_mechanics(self.body.masses, self.body.springs, self.body.dampers)
        elif self.modes and self.modes[0].held:
            bare = held_mechanics(self.J, self.modes)
        else:
            bare = modal_mechanics(self.J, self.modes)
        return bare.loaded(self.viscous, self.load_viscous, self.spring)

    @property
    def is_system(self) -> bool:
        """Whether it was given as a python-control system."""
        return isinstance(self.body, _System)

    @property
    def is_rigid(self) -> bool:
        """Whether motor and load are one."""
        return bool(np.array_equal(self.dynamics.motor, self.dynamics.load))

    @property
    def is_nonlinear(self) -> bool:
        """Whether friction, ripple, a torque limit or the encoder's resolution make it so."""
        dry = self.friction is not None or self.ripple is not None
        return dry or self.torque_limit < inf or self.encoder_step > 0.0

    def system(self) -> control.StateSpace:
        """Return the linear part as a python-control system.

        From (u, d_motor, d_load) to (y, y_rate, y_load, twist, torque, y_motor):
        y is the measured position, y_rate the measured velocity (with two encoders the load's
        position and the motor's velocity), twist load less motor, torque that of the motor, behind
        the current loop. Friction, limit and resolution are left out.
        """
        d = self.dynamics
        position = d.motor if self.sensor == "motor" else d.load
        rate = d.load_rate if self.sensor == "load" else d.motor_rate
        rows = [position, rate, d.load, d.load - d.motor, d.torque[:-1], d.motor]
        feedthrough = np.zeros((6, 3))
        feedthrough[4, 0] = d.torque[-1]
        return linear_system(
            (d.a, d.b, rows, feedthrough),
            0,
            inputs=["u", "d_motor", "d_load"],
            outputs=["y", "y_rate", "y_load", "twist", "torque", "y_motor"],
            states=d.names,
            name="plant",
        )

    def measured_model(self) -> StateModel:
        """Return the numbers from u to what position and velocity are taken from, by encoder."""
        d = self.dynamics
        position = d.motor if self.sensor == "motor" else d.load
        seen = np.array([position, d.motor if self.sensor == "both" else position])
        return StateModel(d.a, d.b[:, :1], seen, np.zeros((2, 1)))

    def transfer(self) -> control.TransferFunction:
        """Return g(s) from u to the measured position y."""
        import control

        from .axis_transfer import transfer_polynomials

        numerator, denominator = transfer_polynomials(self)
        return control.tf(numerator, denominator, inputs=["u"], outputs=["y"], name="plant")


@dataclass(frozen=True)
class _Chain(Frozen):
    """Masses in a row."""

    masses: tuple[float, ...]
    springs: tuple[float, ...]
    dampers: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class _System:
    """Any linear system."""

    system: Any


def chain_axis(
    masses: Sequence[float],
    springs: Sequence[float],
    dampers: Sequence[float] | None = None,
    **others: Any,
) -> Axis:
    """Return an axis of masses in a row; the motor is the first, the load the last.

        m_k·x_k'' = −s_k·(x_k − x_{k+1}) − d_k·(x_k' − x_{k+1}') + the same of k − 1, reversed

    in units that fit: kg m², N m/rad and N m s/rad, or kg, N/m and N s/m.

    Parameters
    ----------
    masses : sequence of n floats
        Positive.
    springs : sequence of n − 1 floats
        Between neighbours, positive.
    dampers : sequence of n − 1 floats, optional
        Between neighbours, ≥ 0. Default: none.
    **others
        As in `Axis`, but for J and modes.

    Returns
    -------
    Axis
        Whose J is the sum of the masses.

    Raises
    ------
    ValueError
        For numbers that are not n − 1 beside n masses, or have the wrong sign.

    Examples
    --------
    >>> chain_axis([1.0, 2.0, 1.0], [100.0, 100.0], viscous=0.1).J
    4.0
    """
    bodies = _numbers("masses", masses, len(np.ravel(masses)))
    between = len(bodies) - 1
    stiffness = _numbers("springs", springs, between)
    damping = _numbers("dampers", [0.0] * between if dampers is None else dampers, between)
    for name, values in (("masses", bodies), ("springs", stiffness)):
        for value in values:
            positive(name, value)
    if min(damping, default=0.0) < 0.0:
        raise ValueError(f"dampers = {shown(dampers)}: expected numbers ≥ 0")
    return Axis(sum(bodies), body=_Chain(bodies, stiffness, damping), **others)


def system_axis(system: Any, **others: Any) -> Axis:
    """Return an axis given as a python-control system from torque to position.

    Parameters
    ----------
    system : StateSpace or TransferFunction (`tf`, `ss`, `zpk`)
        Continuous, one input, one output, two poles more than zeros at least. Motor and load are
        one: what it shows is measured, disturbances act where the torque does.
    **others
        As in `Axis`, but for J, modes, viscous, load_viscous and spring, which the system has.
        J is then the inertia that it shows at low frequency, nan if it does not move freely:
        J = lim 1/(s²·G(s)), s → 0.

    Returns
    -------
    Axis
        In the system's own units.

    Raises
    ------
    ValueError
        For a system that is discrete, improper, or of several inputs or outputs.
    """
    given = state_space(
        system, improper="give two poles more than zeros at least, from torque to position"
    )
    if given.ninputs != 1 or given.noutputs != 1 or given.isdtime(strict=True):
        raise ValueError(
            f"system with {given.ninputs} inputs and {given.noutputs} outputs"
            f"{', discrete' if given.isdtime(strict=True) else ''}: expected a continuous one from "
            "one torque to one position"
        )
    dynamics = linear_dynamics(given)
    free = np.linalg.eigvals(dynamics.a)
    low = 1e-3 * min((abs(free[abs(free) > 0.0])).min(initial=1.0), 1.0)
    gain = (1j * low) ** 2 * complex(given(1j * low))
    moves = abs(gain.imag) < 1e-2 * abs(gain) and gain.real > 0.0
    return Axis(1.0 / gain.real if moves else nan, body=_System(given), **others)


def as_axis(plant: Any) -> Axis:
    """Return any plant as an axis.

    Parameters
    ----------
    plant : Axis, Inertia, FlexibleInertia or python-control system
        A system as in `system_axis`.

    Returns
    -------
    Axis
        With the same transfer function from torque to position, in the plant's own units.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(plant, Axis):
        return plant
    if isinstance(plant, Inertia):
        return Axis(plant.J)
    if isinstance(plant, FlexibleInertia):
        mode = FlexibleMode(plant.frequency_hz, plant.damping, load_fraction=plant.load_fraction)
        return Axis(plant.J, modes=(mode,), sensor=plant.sensor)
    import control

    if isinstance(plant, control.StateSpace | control.TransferFunction):
        return system_axis(plant)
    refuse_data(plant)
    raise TypeError(
        f"plant = {shown(plant)}: expected Inertia, FlexibleInertia, Axis or a python-control "
        "system from torque to position"
    )


def _modes(modes: Any) -> tuple[FlexibleMode, ...]:
    """Return modes that make one axis together."""
    given = (modes,) if isinstance(modes, FlexibleMode) else tuple(modes)
    for mode in given:
        of_kind("modes", mode, FlexibleMode, "FlexibleMode(frequency_hz, damping, …)")
    held = sum(mode.held for mode in given)
    if 0 < held < len(given):
        raise ValueError(
            f"modes: {held} of {len(given)} with the motor held: give all of them so, or all "
            "free-free"
        )
    if held and sum(mode.load_fraction or 0.0 for mode in given) >= 1.0:
        raise ValueError(
            "modes: the load fractions add up to 1 or more: the motor has a share of J, too"
        )
    if not held and len(given) > 1 and any(mode.load_fraction is not None for mode in given):
        raise ValueError(
            "modes: the load_fraction of a free-free mode describes an axis of one mode: give "
            "motor_shape and load_shape, or held=True"
        )
    return given


def _numbers(name: str, values: Any, count: int) -> tuple[float, ...]:
    array = real_array(name, values)
    if array.shape != (count,) or not count + (name != "masses") or not np.isfinite(array).all():
        raise ValueError(
            f"{name} = {shown(values)}: expected {count} finite numbers, "
            f"{'one a mass' if name == 'masses' else 'one between each two masses'}"
        )
    return tuple(array.tolist())
