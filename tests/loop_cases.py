"""Cases of loops, built from plain parameters through the public names of the library."""

from math import factorial, inf, pi, sqrt

import control
import numpy as np

from jounce.plant import (
    PID,
    Axis,
    BackCalculation,
    CascadedPI,
    Clamp,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    LeadLag,
    LowPass,
    Notch,
    Ramp,
    ServoLoop,
    Sine,
    TorqueSine,
    TorqueSteps,
    Wind,
    chain_axis,
    respond,
)
from jounce.shaping import Trajectory, input_shaper

FILTERS = {
    "notch": lambda f: Notch(
        f["zero_hz"],
        f.get("pole_hz"),
        zero_damping=f["zero_damping"],
        pole_damping=f["pole_damping"],
    ),
    "lowpass1": lambda f: LowPass(f["corner_hz"], order=1),
    "lowpass2": lambda f: LowPass(f["corner_hz"], damping=f.get("damping_ratio", 0.7)),
    "leadlag": lambda f: LeadLag(f["zero_hz"], f["pole_hz"]),
}


OF_THE_METHOD = {"scale_rad", "max_step_s", "duration_s"}  # how expected values were computed


class Asked(dict):
    """Parameters that know which of them have been looked at."""

    def __init__(self, given):
        super().__init__({name: asked(value) for name, value in given.items()})
        self.seen = set()

    def __getitem__(self, name):
        self.seen.add(name)
        return super().__getitem__(name)

    def get(self, name, default=None):
        """Return a parameter, which counts as looked at."""
        self.seen.add(name)
        return super().get(name, default)

    def items(self):
        """Return all, which count as looked at."""
        self.seen.update(self)
        return super().items()

    def unread(self):
        """Yield the names of what nothing has looked at."""
        for name, value in super().items():
            if name not in self.seen | OF_THE_METHOD:
                yield name
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, Asked):
                    yield from (f"{name}.{inner}" for inner in part.unread())


def asked(value):
    if isinstance(value, dict):
        return Asked(value)
    return [asked(part) for part in value] if isinstance(value, list) else value


def run_case(parameters):
    """Return what a case expects, bare values in the same nesting.

    Raises ValueError for parameters that have no say in what is returned.
    """
    given = Asked(parameters)
    kinds = {
        "shapers": run_shapers,
        "wind": run_variances,
        "encoder_noise_sigma_rad": run_variances,
    }
    found = next((run for name, run in kinds.items() if name in given), run_response)(given)
    unread = sorted(given.unread())
    if unread:
        raise ValueError(f"parameters {', '.join(unread)}: unknown in a case of this kind")
    return found


def axis_of(parameters):
    plant, friction = parameters["plant"], parameters.get("friction")
    controller = parameters["controller"]
    others = {
        "viscous": plant.get("motor_viscous_nm_s_per_rad", 0.0),
        "load_viscous": plant.get("load_viscous_nm_s_per_rad", 0.0),
        "friction": friction and Friction(friction["coulomb_nm"], friction.get("static_nm")),
        "torque_limit": controller.get("torque_limit_nm", inf),
        "current_lag": parameters.get("current_lag_s", 0.0),
        "encoder_step": controller.get("encoder_step_rad", 0.0),
    }
    if plant["type"] == "chain":
        masses, springs, dampers = chain_numbers(plant)
        return chain_axis(masses, springs, dampers, **others)
    modes = [
        FlexibleMode(
            mode["frequency_hz"],
            mode["damping_ratio"],
            motor_shape=mode["motor_shape"],
            load_shape=mode["load_shape"],
        )
        for mode in plant.get("modes", [])
    ]
    return Axis(plant["J_kg_m2"], modes=modes, **others)


def chain_numbers(plant):
    """Return masses, springs and dampers, whatever the units in their names."""

    def named(*starts):
        return next((plant[name] for name in plant if name.startswith(starts)), None)

    masses, springs = named("mass", "inertia", "J_", "m_"), named("spring", "stiff", "k_")
    return masses, springs, named("damp", "c_")


def controller_of(p):
    if p["type"] == "p_pi":
        law = CascadedPI(
            p["kv_per_s"],
            p["kp_velocity_nm_s_per_rad"],
            p["reset_time_s"],
            velocity_filter=p.get("velocity_filter_s", 0.0),
            velocity_feedforward=p.get("velocity_feedforward", 1.0),
        )
    else:
        law = PID(
            p["kp_nm_per_rad"],
            p["ki_nm_per_rad_s"],
            p["kd_nm_s_per_rad"],
            derivative_filter=p.get("derivative_filter_s", 0.0),
        )
    anti_windup = {
        "conditional": lambda: "conditional",
        "back_calculation": lambda: BackCalculation(p["tracking_time_s"]),
        "clamp": lambda: Clamp(p["integrator_limit_nm"]),
    }.get(p.get("anti_windup", "none"), lambda: None)()
    return Controller(
        law,
        filters=[FILTERS[f["kind"]](f) for f in p.get("filters", [])],
        sample_time=p.get("sample_time_s"),
        delay=p.get("computing_delay_s", 0.0),
        anti_windup=anti_windup,
    )


def feedforward_of(p):
    def gains(name):
        return {int(k): gain for k, gain in p.get(f"{name}_feedforward_of_derivative", {}).items()}

    friction = [p[name] for name in p if name.startswith("friction_feedforward")]
    return Feedforward(gains("torque"), position=gains("position"), friction=(friction or [0.0])[0])


def command_of(p):
    if p["type"] == "sine":
        return Sine(p["amplitude_rad"], p["frequency_hz"])
    if p["type"] == "ramp":
        return Ramp(p["rate_rad_per_s"], p["offset_rad"])
    order = max(map(len, p["coefficients_rad_per_s_power"])) - 1
    factorials = [factorial(k) for k in range(order + 1)]
    states = np.array(
        [np.pad(c, (0, order + 1 - len(c))) for c in p["coefficients_rad_per_s_power"]]
    )
    breaks = np.append(p["start_s"], p["end_s"][-1])
    last = breaks[-1] - breaks[-2]
    end = np.zeros(order + 1)
    end[0] = np.polyval(states[-1][::-1], last)
    return Trajectory(breaks, states * factorials, end_state=end)


def disturbances_of(p):
    steps = [
        TorqueSteps(p[f"{on}_step_at_s"], p[f"{on}_step_nm"], on=on)
        for on in ("motor", "load")
        if f"{on}_step_at_s" in p
    ]
    if "sine_motor_nm" in p:
        steps.append(TorqueSine(p["sine_motor_nm"], p["sine_hz"], on="motor"))
    return steps


def run_response(parameters):
    controller = parameters["controller"]
    loop = ServoLoop(axis_of(parameters), controller_of(controller), feedforward_of(controller))
    response = loop.respond(
        command_of(parameters["command"]),
        duration=parameters["duration_s"],
        disturbance=disturbances_of(parameters.get("disturbance", {})),
        times=parameters["instants_s"],
        start=0.0,
    )
    found = {
        "motor_position_rad": response.motor,
        "load_position_rad": response.load,
        "command_torque_nm": response.torque,
        "motor_torque_nm": response.motor_torque,
        "peak_load_error_rad": response.peak_load_error,
    }
    if "settle_tolerance_rad" in parameters:
        settled = response.settling_time(
            parameters["settle_target_rad"], parameters["settle_tolerance_rad"], of="load"
        )
        found["settling_time_s"] = min(settled, parameters["duration_s"])
    if loop.is_digital:
        e = response.controller_error
        found["rms_controller_error_at_samples_rad"] = np.sqrt(np.mean(e * e))
        found["peak_controller_error_at_samples_rad"] = np.max(np.abs(e))
    if "torque_limit_nm" in controller:
        found["saturated_samples"] = response.saturated_samples
        found["saturated_time_s"] = response.saturated_time
    if "friction" in parameters:
        found["friction_events"] = [list(event) for event in response.friction_events]
        found["stick_intervals_s"] = [list(part) for part in response.stick_intervals]
        found["time_in_stick_s"] = response.time_in_stick
    return found


def run_shapers(p):
    omega, zeta = 2 * pi * p["mode_frequency_hz"], p["mode_damping_ratio"]
    carried = control.ss(control.tf([2 * zeta * omega, omega**2], [1, 2 * zeta * omega, omega**2]))
    command = command_of(p["command"])
    return {kind: run_shaper(kind, p, carried, command) for kind in p["shapers"]}


def run_shaper(kind, p, carried, command):
    """Return what a shaper does to a load on a motor that follows the command exactly."""
    f, zeta = p["mode_frequency_hz"], p["mode_damping_ratio"]
    shaper = input_shaper(kind, f, zeta)
    shaped = shaper.shape(command)

    def state(t):
        """Return position and velocity of the load."""
        out = respond(carried, shaped, t, duration=t)
        x = out.states[:, -1]
        rate = carried.A @ x + carried.B[:, 0] * shaped(t)
        return out.outputs[-1], (carried.C @ rate)[0]

    end = shaped.end_time
    off, rate = state(end)
    off -= float(shaped.end_state[0])
    damped = 2 * pi * f * sqrt(1 - zeta**2)
    return {
        "times_s": shaper.times,
        "amplitudes": shaper.amplitudes,
        "residual_vibration_at_frequency_ratio": {
            str(ratio): float(shaper.residual(ratio * f, zeta))
            for ratio in (0.8, 0.9, 1.0, 1.1, 1.2)
        },
        "shaped_command_rad": shaped(p["instants_s"]),
        "load_position_rad": [state(t)[0] for t in p["instants_s"]],
        "residual_amplitude_at_move_end_rad": np.hypot(
            off, (rate + zeta * 2 * pi * f * off) / damped
        ),
        "move_end_s": end,
    }


def wind_of(p):
    return Wind(
        p["kind"],
        p["sigma_nm"],
        corner_hz=p.get("corner_hz"),
        length_over_speed=p.get("length_over_speed_s"),
        on=p.get("on", "load"),
    )


def run_variances(parameters):
    controller = parameters["controller"]
    loop = ServoLoop(axis_of(parameters), controller_of(controller), feedforward_of(controller))
    noise = parameters.get("encoder_noise_sigma_rad", 0.0)
    wind = wind_of(parameters["wind"]) if "wind" in parameters else None

    def named(found):
        return {
            "load_sigma_at_samples_rad": found.load,
            "motor_sigma_at_samples_rad": found.motor,
            "command_torque_sigma_nm": found.torque,
        }

    found = loop.deviations(wind, encoder_noise=noise)
    result = named(found) | {"load_sigma_time_average_rad": found.load_average}
    if "von_karman_wind" in parameters:
        other = loop.deviations(wind_of(parameters["von_karman_wind"]), encoder_noise=noise)
        result["von_karman_instead"] = named(other)
    return result
