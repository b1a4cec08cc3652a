"""Ten seconds of a digital servo loop at 1 kHz, beside scipy's solve_ivp and python-control.

A flexible axis with current lag, stiction and torque limit under a PID of 1 kHz with 0.4 ms delay.
solve_ivp (DOP853, rtol 1e-9) is started again at every sample, actuation and event, and finds
where the friction changes by its events; input_output_response is called for every hold, with a
smooth friction tanh(v/1e-3). Both are run over the first part of a second and counted as if they
went on so. The batch is of loops with different gains, on all processors; beside it some of them
one by one, and by how much the memory in use has grown at most.

Run: python benchmarks/loops.py
"""

from __future__ import annotations

import os
from collections.abc import Callable
from math import pi
from resource import RUSAGE_SELF, getrusage
from statistics import median
from time import perf_counter, process_time

import control
import numpy as np
from scipy.integrate import solve_ivp
from timing import side_by_side, table

from jounce.plant import (
    PID,
    Axis,
    Controller,
    Feedforward,
    FlexibleMode,
    Friction,
    LoopResponse,
    ServoLoop,
    respond_all,
)
from jounce.shaping import Limits, min_time_move

DT, DELAY, DURATION = 1e-3, 0.4e-3, 10.0
PART = 0.06  # of the duration, for what is slow
BATCH, ALONE = 10_000, 100  # runs at once; runs one by one
J, HZ, ZETA, SHARE, LAG = 2.0, 20.0, 0.01, 0.3, 0.6e-3
COULOMB, STATIC, LIMIT = 3.0, 4.0, 14.0
KP, KI, KD = 1263.31, 4762.56, 65.3451
MOVE = min_time_move(0.5, Limits(velocity=1.0, acceleration=8.0, jerk=200.0))


def loop(kp: float = KP) -> ServoLoop:
    """Return the loop."""
    axis = Axis(
        J,
        modes=FlexibleMode(HZ, ZETA, load_fraction=SHARE),
        friction=Friction(COULOMB, STATIC),
        torque_limit=LIMIT,
        current_lag=LAG,
    )
    law = PID(kp, KI, KD, derivative_filter=DT)
    controller = Controller(law, sample_time=DT, delay=DELAY, anti_windup="conditional")
    return ServoLoop(axis, controller, Feedforward({2: J}))


class ByHand:
    """The same loop in Python, its plant integrated from one sample to the next by a peer."""

    def __init__(self, hold: Callable[[ByHand, float, float], None]) -> None:
        self.hold, self.x, self.u, self.mode = hold, np.zeros(5), 0.0, 0
        self.integral, self.rate, self.past = 0.0, 0.0, 0.0

    def run(self, duration: float) -> float:
        """Return the motor's position at the end."""
        for k in range(round(duration / DT)):
            t = k * DT
            u = self.sample(t)
            self.hold(self, t, t + DELAY)
            self.u = u
            self.hold(self, t + DELAY, t + DT)
        return float(self.x[0])

    def sample(self, t: float) -> float:
        """Return the torque that one sample asks for."""
        e = float(MOVE(t)) - self.x[0]
        self.rate = (DT * self.rate + e - self.past) / (2.0 * DT)
        self.past, self.integral = e, self.integral + DT * e
        w = KP * e + KI * self.integral + KD * self.rate + J * float(MOVE(t, 2))
        u = min(max(w, -LIMIT), LIMIT)
        if u != w and w * e > 0.0:
            self.integral -= DT * e
        return u


def rates(x: np.ndarray, u: float, friction: float) -> list[float]:
    """Return the rates of y, v, twist, its rate, and the motor's torque."""
    omega = 2.0 * pi * HZ
    spring = SHARE * (omega**2 * x[2] + 2.0 * ZETA * omega * x[3])
    push = (x[4] - friction) / ((1.0 - SHARE) * J)
    swing = -(omega**2) * x[2] - 2.0 * ZETA * omega * x[3]
    return [x[1], push + spring, x[3], swing - push, (u - x[4]) / LAG]


def needed(x: np.ndarray) -> float:
    """Return the torque that friction has to hold."""
    omega = 2.0 * pi * HZ
    spring = SHARE * (omega**2 * x[2] + 2.0 * ZETA * omega * x[3])
    return float(x[4] + (1.0 - SHARE) * J * spring)


def by_events(run: ByHand, t: float, end: float) -> None:
    """Advance by solve_ivp, restarted at every event."""
    while t < end:
        if run.mode == 0 and abs(needed(run.x)) > STATIC:
            run.mode = int(np.sign(needed(run.x)))

        def rate(_: float, x: np.ndarray, mode: int = run.mode) -> list[float]:
            return rates(x, run.u, mode * COULOMB if mode else needed(x))

        def stops(_: float, x: np.ndarray, mode: int = run.mode) -> float:
            return float(mode * x[1]) if mode else STATIC - abs(needed(x))

        stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            rate, (t, end), run.x, method="DOP853", rtol=1e-9, atol=1e-12, events=stops
        )
        t, run.x = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            was = run.mode
            run.mode = 0 if was else int(np.sign(needed(run.x)))
            run.x[1] = 0.0 if was else run.x[1]
            t += 0.0 if was else 1e-12


def smooth_plant() -> control.NonlinearIOSystem:
    """Return the plant with a smooth friction."""

    def rate(_: float, x: np.ndarray, u: np.ndarray, __: object) -> np.ndarray:
        return np.array(rates(x, float(u[0]), COULOMB * np.tanh(x[1] / 1e-3)))

    return control.nlsys(rate, None, inputs=1, states=5, outputs=5)


def by_holds(run: ByHand, t: float, end: float, plant: object = None) -> None:
    """Advance by input_output_response over one hold."""
    times = np.array([t, end])
    response = control.input_output_response(
        PLANT if plant is None else plant, times, [run.u, run.u], run.x
    )
    run.x = np.asarray(response.states)[:, -1]


PLANT = smooth_plant()


def rows() -> list[tuple[str, ...]]:
    """Return the table's rows: what, time of 10 s of loop, its ratio to ours."""
    one = loop()
    [ours] = side_by_side(lambda: one.respond(MOVE, DT, duration=DURATION), repeats=15)
    mine = median(ours)
    found = [("jounce", _time(mine), "1", f"{one.respond(MOVE, DT, duration=PART).motor[-1]:.9f}")]
    for name, hold in (("solve_ivp with events", by_events), ("input_output_response", by_holds)):
        begin = perf_counter()
        end = ByHand(hold).run(PART)
        taken = (perf_counter() - begin) * DURATION / PART
        found.append((name, _time(taken), f"{taken / mine:.0f}", f"{end:.9f}"))
    return [*found, batch_row()]


def batch_row() -> tuple[str, ...]:
    """Return what a batch takes: time, that of its runs one by one, processors at work, memory."""
    some = [loop(KP * (1.0 + 1e-5 * i)) for i in range(ALONE)]
    begin = perf_counter()
    for each in some:
        figure(each.respond(MOVE, times=[DURATION]))
    alone = (perf_counter() - begin) / ALONE
    held = getrusage(RUSAGE_SELF).ru_maxrss
    begin, at_work = perf_counter(), process_time()
    loops = (loop(KP * (1.0 + 1e-5 * i)) for i in range(BATCH))
    respond_all(loops, MOVE, times=[DURATION], figures=figure)
    taken, at_work = perf_counter() - begin, process_time() - at_work
    more = (getrusage(RUSAGE_SELF).ru_maxrss - held) / 1024.0
    name = (
        f"jounce, each of {BATCH} in a batch: {taken:.1f} s, CPU {at_work:.1f} s, "
        f"{at_work / taken:.2f} of {os.cpu_count()} processors, {more:.0f} MiB more"
    )
    return name, _time(taken / BATCH), f"{taken / (BATCH * alone):.2f}", ""


def figure(response: LoopResponse) -> int:
    """Return what is wanted of a run."""
    return response.saturated_samples


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms" if seconds < 1.0 else f"{seconds:.0f} s"


HEADER = ("10 s of a loop", "time", "time / jounce", f"motor after {1e3 * PART:.0f} ms")

if __name__ == "__main__":
    print(table(HEADER, rows()))
