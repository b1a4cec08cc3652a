"""Loops by scipy's solve_ivp, started again at every event: slow, shares nothing with ours."""

from itertools import pairwise
from math import floor, inf, pi, tan

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

SPLIT, FINE = 6, 5e-4  # of a piece of time, where extremes are looked for
AGAIN = 1e-10  # events nearer to the start of a piece are the one that began it


def matrices(plant):
    """Return M, C, K and the rows of motor and load."""
    if plant["type"] == "chain":
        masses, springs, dampers = plant["masses"], plant["springs"], plant["dampers"]
        n = len(masses)
        c, k = np.zeros((n, n)), np.zeros((n, n))
        for i, (spring, damper) in enumerate(zip(springs, dampers, strict=True)):
            pair = np.zeros(n)
            pair[i], pair[i + 1] = 1.0, -1.0
            k += spring * np.outer(pair, pair)
            c += damper * np.outer(pair, pair)
        m, motor, load = np.diag(masses).astype(float), np.eye(n)[0], np.eye(n)[-1]
    else:
        modes, inertia = plant.get("modes", []), plant["J_kg_m2"]
        omega = np.array([0.0] + [2 * pi * mode["frequency_hz"] for mode in modes])
        zeta = np.array([0.0] + [mode["damping_ratio"] for mode in modes])
        m, k, c = inertia * np.eye(len(omega)), inertia * omega**2, inertia * 2 * zeta * omega
        k, c = np.diag(k), np.diag(c)
        motor = np.array([1.0] + [mode["motor_shape"] for mode in modes])
        load = np.array([1.0] + [mode["load_shape"] for mode in modes])
    c = c + plant.get("motor_viscous_nm_s_per_rad", 0.0) * np.outer(motor, motor)
    c = c + plant.get("load_viscous_nm_s_per_rad", 0.0) * np.outer(load, load)
    return m, c, k, motor, load


def commanded(p, t, k):
    """Return the k-th derivative of the command at t, of the piece that begins there."""
    if p["type"] == "ramp":
        return (p["offset_rad"] + p["rate_rad_per_s"] * t, p["rate_rad_per_s"])[k] if k < 2 else 0.0
    if p["type"] == "sine":
        omega = 2 * pi * p["frequency_hz"]
        return p["amplitude_rad"] * omega**k * np.sin(omega * t + k * pi / 2)
    starts, ends = p["start_s"], p["end_s"]
    if t >= ends[-1] - 1e-12:
        t, i, over = ends[-1], len(starts) - 1, k > 0
    else:
        i = max(np.searchsorted(np.array(starts) - 1e-12, t, side="right") - 1, 0)
        over = False
    piece = np.polynomial.Polynomial(p["coefficients_rad_per_s_power"][i])
    return 0.0 if over else float(piece.deriv(k)(t - starts[i]) if k else piece(t - starts[i]))


def tustin(f, dt):
    """Return numerator and denominator in 1/z of a filter."""
    if f["kind"] == "notch":
        w1, w2 = 2 * pi * f["zero_hz"], 2 * pi * f["pole_hz"]
        at, ratio = w1, (w2 / w1) ** 2
        num = [ratio, ratio * 2 * f["zero_damping"] * w1, ratio * w1**2]
        den = [1.0, 2 * f["pole_damping"] * w2, w2**2]
    elif f["kind"] == "leadlag":
        wz, wp = 2 * pi * f["zero_hz"], 2 * pi * f["pole_hz"]
        at, num, den = (wz * wp) ** 0.5, [0.0, 1 / wz, 1.0], [0.0, 1 / wp, 1.0]
    else:
        at = 2 * pi * f["corner_hz"]
        second = f["kind"] == "lowpass2"
        num = [0.0, 0.0, at**2] if second else [0.0, 0.0, at]
        den = [1.0, 2 * f["damping_ratio"] * at, at**2] if second else [0.0, 1.0, at]
    c = at / tan(at * dt / 2)
    if num[0] == den[0] == 0.0:  # first order: without a common root at z = −1
        return [[a[1] * c + a[2], a[2] - a[1] * c] for a in (num, den)]
    return [
        [a[0] * c * c + a[1] * c + a[2], 2 * (a[2] - a[0] * c * c), a[0] * c * c - a[1] * c + a[2]]
        for a in (num, den)
    ]


class Sampled:
    """A digital controller, line by line as the cases' language says."""

    def __init__(self, p, command):
        self.p, self.command, self.dt = p, command, p["sample_time_s"]
        self.filters = [(*tustin(f, self.dt), [], []) for f in p.get("filters", [])]
        self.integral = self.rate = 0.0
        self.past = None

    def __call__(self, t, y):
        """Return error, torque asked for, torque."""
        p, dt = self.p, self.dt
        r = [commanded(self.command, t, k) for k in range(8)]
        step = p.get("encoder_step_rad", 0.0)
        y = step * floor(y / step + 0.5) if step else y
        ahead = p.get("position_feedforward_of_derivative", {})
        e = r[0] + sum(gain * r[int(k)] for k, gain in ahead.items()) - y
        if p["type"] == "pid":
            w, integrated, ki = self.pid(e)
        else:
            w, integrated, ki = self.p_pi(e, y, r[1])
        for num, den, ins, outs in self.filters:
            ins.insert(0, w)
            w = sum(b * x for b, x in zip(num, ins, strict=False))
            w = (w - sum(a * x for a, x in zip(den[1:], outs, strict=False))) / den[0]
            outs.insert(0, w)
            del ins[3:], outs[3:]
        w += sum(g * r[int(k)] for k, g in p.get("torque_feedforward_of_derivative", {}).items())
        w += p.get("friction_feedforward_nm", 0.0) * np.sign(r[1])
        limit = p.get("torque_limit_nm", inf)
        u = min(max(w, -limit), limit)
        way = p.get("anti_windup", "none")
        if way == "conditional" and u != w and w * integrated > 0:
            self.integral -= dt * integrated
        if way == "back_calculation":
            self.integral += dt / p["tracking_time_s"] * (u - w) / ki
        if way == "clamp":
            most = p["integrator_limit_nm"] / ki
            self.integral = min(max(self.integral, -most), most)
        return e, w, u

    def slope(self, value, filter_time):
        """Return the filtered slope of values from sample to sample."""
        past = value if self.past is None else self.past
        self.rate = (filter_time * self.rate + value - past) / (filter_time + self.dt)
        self.past = value
        return self.rate

    def pid(self, e):
        """Return torque, what is integrated and its gain."""
        p = self.p
        rate = self.slope(e, p.get("derivative_filter_s", 0.0))
        self.integral += self.dt * e
        ki = p["ki_nm_per_rad_s"]
        return p["kp_nm_per_rad"] * e + ki * self.integral + p["kd_nm_s_per_rad"] * rate, e, ki

    def p_pi(self, e, y, r_rate):
        """Return torque, what is integrated and its gain."""
        p = self.p
        v = self.slope(y, p.get("velocity_filter_s", 0.0))
        ev = p["kv_per_s"] * e + p.get("velocity_feedforward", 1.0) * r_rate - v
        self.integral += self.dt * ev
        ki = p["kp_velocity_nm_s_per_rad"] / p["reset_time_s"]
        return p["kp_velocity_nm_s_per_rad"] * ev + ki * self.integral, ev, ki


class Slow:
    """One run: states are q, q′, then the motor's torque and what a continuous PID remembers."""

    def __init__(self, parameters):
        self.p, self.control = parameters, parameters["controller"]
        self.command, self.end = parameters["command"], parameters["duration_s"]
        self.m, self.c, self.k, self.motor, self.load = matrices(parameters["plant"])
        self.n = len(self.m)
        self.inverse = np.linalg.inv(self.m)
        self.mobility = self.motor @ self.inverse @ self.motor
        self.lag = parameters.get("current_lag_s", 0.0)
        self.friction = parameters.get("friction")
        self.digital = "sample_time_s" in self.control
        self.disturbing = parameters.get("disturbance", {})
        self.mode, self.u, self.side = 0, 0.0, 0
        self.x = np.zeros(2 * self.n + 3)

    def disturbed(self, t):
        """Return the torques on motor and load of the piece that begins at or before t."""
        d = self.disturbing
        found = [
            sum(
                v
                for at, v in zip(
                    d.get(f"{on}_step_at_s", []), d.get(f"{on}_step_nm", []), strict=True
                )
                if at <= self.begin + 1e-12
            )
            for on in ("motor", "load")
        ]
        if "sine_motor_nm" in d:
            found[0] += d["sine_motor_nm"] * np.sin(2 * pi * d["sine_hz"] * t)
        return found

    def asked(self, t, x):
        """Return torque asked for and the rates of integral and filter, of a continuous PID."""
        p, n = self.control, self.n
        r = [self.within(t, k) for k in range(8)]
        ahead = {0: 1.0} | {
            int(k): g for k, g in p.get("position_feedforward_of_derivative", {}).items()
        }
        e = sum(g * r[k] for k, g in ahead.items()) - self.motor @ x[:n]
        e1 = sum(g * r[k + 1] for k, g in ahead.items()) - self.motor @ x[n : 2 * n]
        filter_time = p.get("derivative_filter_s", 0.0)
        rate, own = (x[-1], (e1 - x[-1]) / filter_time) if filter_time else (e1, 0.0)
        w = p["kp_nm_per_rad"] * e + p["ki_nm_per_rad_s"] * x[-2] + p["kd_nm_s_per_rad"] * rate
        w += sum(g * r[int(k)] for k, g in p.get("torque_feedforward_of_derivative", {}).items())
        w += p.get("friction_feedforward_nm", 0.0) * np.sign(r[1])
        return w, e, own

    def within(self, t, k):
        """Return the command's derivative from the piece in force, even at its end."""
        if self.command["type"] != "polynomial":
            return commanded(self.command, t, k)
        starts = np.array(self.command["start_s"])
        if self.begin >= self.command["end_s"][-1] - 1e-12:
            return commanded(self.command, t, k)
        i = max(np.searchsorted(starts - 1e-12, self.begin, side="right") - 1, 0)
        piece = np.polynomial.Polynomial(self.command["coefficients_rad_per_s_power"][i])
        return float((piece.deriv(k) if k else piece)(t - starts[i]))

    def rates(self, t, x):
        """Return the rates of the states."""
        return self.derivative(t, x)[0]

    def derivative(self, t, x):
        """Return the rates and the torque that friction has to hold."""
        n = self.n
        limit = self.control.get("torque_limit_nm", inf)
        own = np.zeros(2)
        if self.digital:
            u = self.u
        else:
            w, e, rate = self.asked(t, x)
            u = self.side * limit if self.side else w
            own[:] = e, rate
            way = self.control.get("anti_windup", "none")
            if way == "back_calculation":
                track = self.control["tracking_time_s"] * self.control["ki_nm_per_rad_s"]
                own[0] += (u - w) / track
            if way == "conditional" and self.side * e > 0:
                own[0] = 0.0
        torque = x[2 * n] if self.lag else u
        on_motor, on_load = self.disturbed(t)
        force = self.motor * (torque + on_motor) + self.load * on_load
        force = force - self.c @ x[n : 2 * n] - self.k @ x[:n]
        needed = self.motor @ self.inverse @ force / self.mobility
        if self.friction:
            held = needed if self.mode == 0 else self.mode * self.friction["coulomb_nm"]
            force = force - self.motor * held
        rates = np.zeros_like(x)
        rates[:n], rates[n : 2 * n] = x[n : 2 * n], self.inverse @ force
        rates[2 * n] = (u - torque) / self.lag if self.lag else 0.0
        rates[2 * n + 1 :] = own
        return rates, needed, u, torque

    def events(self):
        """Return functions that fall through 0 where the mode changes."""
        found = []
        if self.friction:
            static = self.friction["static_nm"]
            if self.mode:
                found.append(lambda _, x: self.mode * (self.motor @ x[self.n : 2 * self.n]))
            else:
                found.append(lambda t, x: static - abs(self.derivative(t, x)[1]))
        if not self.digital and "torque_limit_nm" in self.control:
            limit = self.control["torque_limit_nm"]
            if self.side:
                found.append(lambda t, x: self.side * self.asked(t, x)[0] - limit)
                if self.control.get("anti_windup") == "conditional":
                    found.append(lambda t, x: abs(self.asked(t, x)[1]))
            else:
                found.append(lambda t, x: limit - abs(self.asked(t, x)[0]))
        for f in found:
            f.terminal, f.direction = True, -1.0
        return found

    def marks(self):
        """Return the times at which something changes."""
        times = {0.0, self.end}
        if self.command["type"] == "polynomial":
            times |= {*self.command["start_s"], *self.command["end_s"]}
        for on in ("motor", "load"):
            times |= set(self.disturbing.get(f"{on}_step_at_s", []))
        if self.digital:
            dt, delay = self.control["sample_time_s"], self.control["computing_delay_s"]
            self.count = floor(self.end / dt + 1e-9) + (self.end / dt % 1 > 1e-9)
            self.sample_times = [k * dt for k in range(self.count)]
            times |= {t for k in range(self.count) for t in (k * dt, k * dt + delay)}
        found = sorted(t for t in times if t <= self.end)
        return [t for i, t in enumerate(found) if not i or t - found[i - 1] > 1e-12]

    def run(self):
        """Return what a case expects."""
        p = self.p
        self.out = {name: [] for name in ("motor", "load", "u", "torque")}
        self.instants, self.peak, self.settled = list(p["instants_s"]), 0.0, 0.0
        self.slips, self.sticks, self.since = [], [], 0.0
        marks = self.marks()
        digital = Sampled(self.control, self.command) if self.digital else None
        errors, done, acted = [], 0, 0
        for t, until in pairwise(marks):
            while digital and done < self.count and self.sample_times[done] <= t + 1e-12:
                errors.append(digital(self.sample_times[done], self.motor @ self.x[: self.n]))
                done += 1
            while acted < done:
                at = self.sample_times[acted] + self.control["computing_delay_s"]
                if at > t + 1e-12:
                    break
                self.u, acted = errors[acted][2], acted + 1
            self.advance(t, until)
        return self.found(errors)

    def advance(self, t, until):
        """Integrate from one mark to the next."""
        self.begin, self.until = t, until
        while t < until - 1e-14:
            if self.friction and self.mode == 0:
                needed = self.derivative(t, self.x)[1]
                if abs(needed) > self.friction["static_nm"] * (1 + 1e-13):
                    self.change(t, int(np.sign(needed)))
            if not self.digital and "torque_limit_nm" in self.control and not self.side:
                asked = self.asked(t, self.x)[0]
                if abs(asked) > self.control["torque_limit_nm"] * (1 + 1e-13):
                    self.side = int(np.sign(asked))
            t = self.piece(t, until)

    def piece(self, t, until):
        """Integrate to the next event or the end; return its time."""
        events = self.events()
        scale = self.p.get("scale_rad", 0.1)
        found = solve_ivp(
            self.rates,
            (t, until),
            self.x,
            method="DOP853",
            rtol=1e-12,
            atol=1e-14 * scale,
            events=events,
            dense_output=True,
            max_step=0.004,
        )
        at = float(found.t[-1])
        if found.status == 1 and at - t < AGAIN:  # the event that began this piece: go past it
            ahead = solve_ivp(
                self.rates,
                (t, min(t + 2 * AGAIN, until)),
                self.x,
                method="DOP853",
                rtol=1e-12,
                atol=1e-14 * scale,
                dense_output=True,
            )
            self.look(ahead)
            self.x = ahead.y[:, -1]
            return float(ahead.t[-1])
        self.look(found)
        self.x = found.y[:, -1]
        if found.status == 1:
            which = next(i for i, times in enumerate(found.t_events) if len(times))
            self.happen(at, which)
        return at

    def happen(self, t, which):
        """Change what an event changes."""
        if self.friction and which == 0:
            if self.mode == 0:
                self.change(t, int(np.sign(self.derivative(t, self.x)[1])))
                return
            rate = self.inverse @ self.motor / self.mobility
            self.x[self.n : 2 * self.n] -= rate * (self.motor @ self.x[self.n : 2 * self.n])
            was, self.mode = self.mode, 0
            needed = self.derivative(t, self.x)[1]
            after = 0 if abs(needed) <= self.friction["static_nm"] else int(np.sign(needed))
            self.mode = was
            self.change(t, after)
        elif self.side:
            limit = self.control["torque_limit_nm"]
            if abs(self.side * self.asked(t, self.x)[0] - limit) < 1e-6 * limit:
                self.side = 0
        else:
            self.side = int(np.sign(self.asked(t, self.x)[0]))

    def change(self, t, mode):
        """Change the mode of the friction."""
        self.slips.append([t, self.mode, mode])
        if self.mode == 0:
            self.sticks.append([self.since, t])
        if mode == 0:
            self.since = t
        self.mode = mode

    def look(self, found):
        """Keep what is asked for of a piece just integrated."""
        t, end = float(found.t[0]), float(found.t[-1])
        while self.instants and self.instants[0] <= end:
            at = self.instants.pop(0)
            x = found.sol(at)
            _, _, u, torque = self.derivative(at, x)
            for name, value in zip(
                self.out,
                (self.motor @ x[: self.n], self.load @ x[: self.n], u, torque),
                strict=True,
            ):
                self.out[name].append(value)
        inner = np.linspace(t, end, max(SPLIT, int((end - t) / FINE)))
        states = found.sol(inner)
        r = np.array([self.within(a, 0) for a in inner])
        y = self.load @ states[: self.n]
        off = np.abs(r - y)
        i = int(off.argmax())
        if off[i] > self.peak * (1 - 1e-3):
            ends = inner[max(i - 1, 0)], inner[min(i + 1, len(inner) - 1)]
            best = minimize_scalar(
                lambda a: -abs(self.within(a, 0) - self.load @ found.sol(a)[: self.n]),
                bounds=ends,
                method="bounded",
                options={"xatol": 1e-9},
            )
            self.peak = max(self.peak, float(off[i]), -best.fun)
        if "settle_tolerance_rad" in self.p:
            self.outside(found, inner, y)

    def outside(self, found, times, y):
        """Move the settling time on to where the load comes back within the tolerance last."""
        target, tolerance = self.p["settle_target_rad"], self.p["settle_tolerance_rad"]
        beyond = np.abs(y - target) > tolerance
        if not beyond.any():
            return
        last = int(np.flatnonzero(beyond)[-1])
        if last == len(times) - 1:
            self.settled = float(times[-1])
            return
        low, high = times[last], times[last + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            off = abs(self.load @ found.sol(middle)[: self.n] - target) > tolerance
            low, high = (middle, high) if off else (low, middle)
        self.settled = float(high)

    def found(self, errors):
        """Return what has been gathered."""
        result = {
            "motor_position_rad": self.out["motor"],
            "load_position_rad": self.out["load"],
            "command_torque_nm": self.out["u"],
            "motor_torque_nm": self.out["torque"],
            "peak_load_error_rad": self.peak,
        }
        if "settle_tolerance_rad" in self.p:
            result["settling_time_s"] = self.settled
        if self.digital:
            e = np.array([error[0] for error in errors])
            result["rms_controller_error_at_samples_rad"] = float(np.sqrt(np.mean(e * e)))
            result["peak_controller_error_at_samples_rad"] = float(np.abs(e).max())
            if "torque_limit_nm" in self.control:
                count = sum(w != u for _, w, u in errors)
                result["saturated_samples"] = count
                result["saturated_time_s"] = count * self.control["sample_time_s"]
        if self.friction:
            if self.mode == 0:
                self.sticks.append([self.since, self.end])
            result["friction_events"] = self.slips
            result["stick_intervals_s"] = self.sticks
            result["time_in_stick_s"] = sum(b - a for a, b in self.sticks)
        return result


def run_slowly(parameters):
    """Return what `run_case` has to return for these parameters."""
    return Slow(parameters).run()
