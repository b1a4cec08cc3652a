"""A telescope axis as it is, and its survey, that several tests have in common."""

from functools import cache
from math import pi

from jounce.analysis import Labels, Move, Requirement, Tracking, survey
from jounce.plant import (
    Axis,
    Controller,
    FlexibleMode,
    Friction,
    InertiaFeedforward,
    Notch,
    Ramp,
    ServoLoop,
    Wind,
    design_pid,
)

DEGREE = pi / 180.0
ARCSEC = DEGREE / 3600.0
MAS = 1e-3 * ARCSEC
J = 1000.0
GAINS = design_pid(J, crossover_hz=1.0, phase_margin_deg=45.0, lower_gain_margin_db=12.0)
BOUNDS = (10.5 * DEGREE, 10.5 * DEGREE, 42.0 * DEGREE)


def mode(damping=0.01):
    """Return a mode of 6 Hz with the motor held, half of the load."""
    return FlexibleMode(6.0, damping, load_fraction=0.5, held=True)


def move(name="slew", bounds=BOUNDS, **others):
    return Move(
        name=name,
        distance=3.5 * DEGREE,
        bounds=bounds,
        limits_name="axis",
        settle_to=50.0 * MAS,
        **others,
    )


SMOOTH = move("smooth slew", (*BOUNDS, 600.0 * DEGREE))
LABELS = Labels("Telescope azimuth", "angle", "arcsec", ARCSEC)
AXIS = Axis(J, modes=[mode()])
LIMITED = Axis(
    J, modes=[mode()], torque_limit=150.0, encoder_step=5.0 * MAS, friction=Friction(2.0, 2.5)
)
DIGITAL = Controller(
    GAINS,
    sample_time=1e-3,
    delay=1.5e-3,
    filters=[Notch(8.485, zero_damping=0.1, pole_damping=0.7)],
    anti_windup="conditional",
)
REAL = ServoLoop(LIMITED, DIGITAL, InertiaFeedforward(J))


@cache
def real_survey():
    """Return the survey of a delayed, digital, flexible, sticking and saturating loop."""
    return survey(
        REAL,
        [move(), SMOOTH],
        wind=Wind("von_karman", 5.0, length_over_speed=2.0),
        encoder_noise=5.0 * MAS,
        torque_step=10.0,
        tracking=[Tracking("sidereal", Ramp(15.0 * ARCSEC), 20.0, after=5.0)],
        requirements=[
            Requirement("phase_margin", least=30.0),
            Requirement("sensitivity_peak", most=2.0),
            Requirement("load_settling", most=2.0),
            Requirement("slew.peak_torque", most=160.0),
        ],
        labels=LABELS,
    )
