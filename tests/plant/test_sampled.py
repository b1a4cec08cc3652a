"""Sampled plants: staircases simulated by brute force, spectra summed, 50 digits, errors."""

from math import inf, nan, pi

import control
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import matrix_balance
from tiers import some

from jounce.plant import PID, FlexibleInertia, Inertia, zero_order_hold
from jounce.plant.sampled import MAX_DELAY

AXIS = FlexibleInertia(2.0, 3.0, 0.02, load_fraction=0.4)
HELD = 1e-11
"""Error of a sampled response, relative to its peak."""


def random_plant(seed, states, inputs, outputs):
    """Return a random system with feedthrough, its rightmost pole at −0.2."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(states, states))
    a -= (0.2 + np.linalg.eigvals(a).real.max(initial=-0.2)) * np.eye(states)
    return control.ss(
        a,
        rng.normal(size=(states, inputs)),
        rng.normal(size=(outputs, states)),
        rng.normal(size=(outputs, inputs)),
    )


def run(system, inputs, initial):
    """Return states and outputs (…, N) of a discrete system, from its equation."""
    x, states, outputs = np.array(initial, dtype=float), [], []
    for u in inputs.T:
        states.append(x)
        outputs.append(system.C @ x + system.D @ u)
        x = system.A @ x + system.B @ u
    return np.array(states).T, np.array(outputs).T


def check_close(found, expected, text=""):
    slack = HELD * max(np.abs(expected).max(initial=0.0), 1e-300)
    np.testing.assert_allclose(found, expected, rtol=0, atol=slack, err_msg=text)


# Against simulations


@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(0, 6),
    inputs=st.integers(1, 3),
    outputs=st.integers(1, 3),
    dt=st.sampled_from([1e-3, 0.1, 2.0]),
)
def test_without_delay_it_is_python_controls_sample_system(seed, states, inputs, outputs, dt):
    plant = random_plant(seed, states, inputs, outputs)
    ours = zero_order_hold(plant, dt)
    text = f"random_plant({seed}, {states}, {inputs}, {outputs}), dt={dt}"
    assert ours.dt == dt
    if not states:
        np.testing.assert_array_equal(ours.D, plant.D)
        return
    theirs = control.sample_system(plant, dt, "zoh")
    for name in "ABCD":
        check_close(getattr(ours, name), getattr(theirs, name), f"{text}: {name}")


@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.integers(1, 5),
    inputs=st.integers(1, 2),
    outputs=st.integers(1, 3),
    parts=st.integers(1, 7),
    late=st.integers(0, 20),
    dt=st.sampled_from([0.05, 1.3]),
)
def test_a_delayed_staircase_simulated_in_small_steps(
    seed, states, inputs, outputs, parts, late, dt
):
    """The delay is late/parts of dt; python-control samples the plant every dt/parts."""
    plant, rng = random_plant(seed, states, inputs, outputs), np.random.default_rng(seed)
    commands, start = rng.normal(size=(inputs, 40)), rng.normal(size=states)
    fine = control.sample_system(plant, dt / parts, "zoh")
    torques = np.hstack([np.zeros((inputs, late)), np.repeat(commands, parts, axis=1)])
    expected = [part[:, : 40 * parts : parts] for part in run(fine, torques, start)]
    held = zero_order_hold(plant, dt, delay=dt * late / parts)
    assert held.nstates == states + inputs * -(-late // parts)
    initial = np.concatenate([start, np.zeros(held.nstates - states)])
    found, seen = run(held, commands, initial)
    text = f"random_plant({seed}, {states}, {inputs}, {outputs}), dt={dt}, {late}/{parts} late"
    check_close(found[:states], expected[0], text)
    check_close(seen, expected[1], text)


@pytest.mark.parametrize("delay", [0.0, 0.0123, 0.1, 0.1 * np.sqrt(2), 0.2999])
def test_a_delayed_staircase_integrated(delay):
    """Any length of delay, by a Runge-Kutta method restarted at each step of the staircase."""
    dt, system = 0.1, AXIS.system()
    torques = np.random.default_rng(5).normal(size=12)
    held = zero_order_hold(system, dt, delay=delay)
    initial = np.zeros(held.nstates)
    initial[:4] = start = [0.3, -1.0, 0.02, 0.5]
    found, _ = run(held, np.append(torques, 0.0)[None, :], initial)
    state, here = np.array(start), 0.0
    changes = delay + dt * np.arange(12)
    samples = dt * np.arange(13)
    stops = np.unique(np.concatenate([changes, samples]))
    for stop in stops[stops <= samples[-1]]:
        if stop > here:
            past = np.flatnonzero(changes <= here)
            torque = torques[past[-1]] if past.size else 0.0
            slope = system.B[:, 0] * torque
            state = solve_ivp(
                lambda _, x, slope=slope: system.A @ x + slope,
                (here, stop), state, method="DOP853", rtol=1e-13, atol=1e-14,
            ).y[:, -1]  # fmt: skip
            here = stop
        near = np.flatnonzero(abs(samples - stop) < 1e-12)
        if near.size:
            np.testing.assert_allclose(
                found[:4, near[0]], state, rtol=0, atol=1e-10, err_msg=f"sample {near[0]}"
            )


# Against formulas


def test_an_inertia_with_a_delay_has_its_textbook_matrices():
    """Torque 1 over the first τ, or the last h − τ, of a sample."""
    for h, tau in ((1.0, 0.5), (0.2, 0.05), (3.0, 2.9)):
        held = zero_order_hold(Inertia(1.0).system(), h, delay=tau)
        late = h - tau
        expected = [[1, h, tau * (h - tau / 2)], [0, 1, tau], [0, 0, 0]]
        np.testing.assert_allclose(held.A, expected, rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(held.B.ravel(), [late**2 / 2, late, 1], rtol=1e-14)


def sampled_spectrum(transfer, omega, dt, delay, terms=100_000):
    """Return Σ_k P(s_k)·e^(−s_k·τ)·(1 − e^(−s_k·dt))/(s_k·dt), s_k = j(ω + 2πk/dt), and its tail.

    What is left out sums 1/|s_k|² times |s·P|, which falls there.
    """
    s = 1j * (omega + 2 * pi / dt * np.arange(-terms, terms + 1))
    jump = 1 - np.exp(-1j * omega * dt)
    values = transfer(s)
    edge = 1.01 * np.abs(values[[0, -1]] * s[[0, -1]]).max()
    tail = edge * abs(jump) / dt * 2 / (terms - 1) * (dt / 2 / pi) ** 2
    return np.sum(values * np.exp(-s * delay) * jump / (s * dt)), tail


PLANTS = {
    "inertia": Inertia(2.0),
    "motor": AXIS,
    "load": FlexibleInertia(2.0, 3.0, 0.02, load_fraction=0.4, sensor="load"),
}


@pytest.mark.parametrize("plant", list(PLANTS.values()), ids=list(PLANTS))
@pytest.mark.parametrize("dt", some([0.02, 0.4, 0.15], 2))
@pytest.mark.parametrize("share", some([0.0, 0.37, 2.5, 1.0], 3))
def test_the_response_is_the_sum_of_all_aliases(plant, dt, share):
    """Position and its rate; the rate's aliases fall with 1/k² only, so its tail is larger."""
    transfer, held = plant.transfer(), zero_order_hold(plant.system(), dt, delay=share * dt)
    g, d = transfer.num_array[0, 0], transfer.den_array[0, 0]
    for omega in (0.3 / dt, 2.0 / dt):
        found = held(np.exp(1j * omega * dt))[:2, 0]
        for i in (0, 1):
            expected, tail = sampled_spectrum(
                lambda s, i=i: s**i * np.polyval(g, s) / np.polyval(d, s), omega, dt, share * dt
            )
            assert tail <= (1e-9, 1e-4)[i] * abs(expected)
            assert abs(found[i] - expected) <= tail + 1e-11 * abs(expected), (omega, i)


@pytest.mark.parametrize("whole", [1, 2, 7])
@pytest.mark.parametrize("rest", [0.0, 0.3])
def test_whole_samples_of_delay_are_powers_of_z(whole, rest):
    plant = random_plant(11, 3, 2, 2)
    z = np.exp(0.7j)
    short, long = (zero_order_hold(plant, 0.1, delay=0.1 * n) for n in (rest, rest + whole))
    np.testing.assert_allclose(long(z), short(z) / z**whole, rtol=1e-12)


def test_the_response_does_not_jump_where_a_delay_becomes_whole():
    z = np.exp(0.9j)
    system = AXIS.system()
    values = [zero_order_hold(system, 0.1, delay=0.3 + x)(z) for x in (-1e-9, 0.0, 1e-9)]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-7)
    np.testing.assert_allclose(values[2], values[1], rtol=1e-7)
    assert abs(values[2] - values[1]).max() > 0.0


@pytest.mark.parametrize("dt", [1e-3, 0.1, 1e-7, 3.3e5])
@pytest.mark.parametrize("count", [1, 3, 6, 49, 1000])
def test_a_delay_of_whole_samples_is_taken_for_one_whatever_its_rounding(dt, count):
    for delay in (count * dt, sum([dt] * count) if count < 50 else count * dt):
        held = zero_order_hold(Inertia(1.0).system(), dt, delay=delay)
        assert held.nstates == 2 + count, delay
        np.testing.assert_array_equal(np.count_nonzero(held.A[:2], axis=0)[2:-1], 0)


def exact(plant, time, digits=60):
    """Return e^(A·t) and its integral times B by Taylor series and squaring, in many digits."""
    n, k = plant.B.shape
    with mpmath.workdps(digits):
        whole = mpmath.zeros(n + k)
        whole[:n, :n] = mpmath.matrix(plant.A.tolist())
        whole[:n, n:] = mpmath.matrix(plant.B.tolist())
        squarings = 40
        small = whole * (mpmath.mpf(time) / 2**squarings)
        total = term = mpmath.eye(n + k)
        for i in range(1, 60):
            term = term * small / i
            total += term
        for _ in range(squarings):
            total = total * total
        both = np.array(total.tolist(), dtype=float)
    return both[:n, :n], both[:n, n:]


PRECISE = {
    "inertia": (Inertia(3.0).system(), 0.7),
    "small": (Inertia(1e-9).system(), 1e-9),
    "large": (Inertia(1e9).system(), 1e9),
    "axis": (AXIS.system(), 0.01),
    "radio": (FlexibleInertia(2e-9, 1e6, 0.01).system(), 1e-9),
    "slow": (FlexibleInertia(2e9, 1e-6, 0.0, sensor="load").system(), 1e5),
    "swinging": (FlexibleInertia(2.0, 10.0, 1e-3, load_fraction=0.9).system(), 0.77),
    "random": (random_plant(3, 5, 2, 1), 0.3),
}


@pytest.mark.parametrize(("plant", "dt"), list(PRECISE.values()), ids=list(PRECISE))
def test_matrices_keep_their_digits_in_any_unit(plant, dt):
    held = zero_order_hold(plant, dt)
    balanced, (scale, _) = matrix_balance(plant.A, permute=False, separate=True)
    slack = 1e-13 * max(1.0, np.abs(balanced).sum(axis=0).max() * dt)
    a, b = exact(plant, dt)
    assert (
        np.abs((held.A - a) * scale / scale[:, None]).max()
        <= slack * np.abs(balanced * 0 + 1).max()
    )
    peaks = np.abs(b / scale[:, None]).max(axis=0)
    assert (np.abs((held.B - b) / scale[:, None]).max(axis=0) <= slack * peaks).all()


# Names, special systems and errors


def test_signals_keep_their_names():
    plant = control.ss(
        [[-1.0]], [[1.0, 2.0]], [[1.0], [3.0]], np.zeros((2, 2)),
        inputs=["left", "right"], outputs=["p", "q"], states=["x"], name="cart",
    )  # fmt: skip
    held = zero_order_hold(plant, 0.5, delay=0.7)
    assert isinstance(held, control.StateSpace)
    assert (held.name, held.dt) == ("cart", 0.5)
    assert held.input_labels == ["left", "right"]
    assert held.output_labels == ["p", "q"]
    past = ["left_past_1", "right_past_1", "left_past_2", "right_past_2"]
    assert held.state_labels == ["x", *past]
    inputs = np.random.default_rng(0).normal(size=(2, 5))
    states, _ = run(held, inputs, np.zeros(5))
    np.testing.assert_array_equal(states[1:3, 1:], inputs[:, :-1])
    np.testing.assert_array_equal(states[3:, 2:], inputs[:, :-2])


def test_a_transfer_function_is_held_too():
    held = zero_order_hold(AXIS.transfer(), 0.1, delay=0.03)
    z = np.exp(0.4j)
    expected = zero_order_hold(AXIS.system(), 0.1, delay=0.03)(z)[0, 0]
    assert held(z) == pytest.approx(expected, rel=1e-10)
    assert (held.name, held.input_labels, held.output_labels) == ("plant", ["u"], ["y"])


@pytest.mark.parametrize(("delay", "power"), [(0.0, 0), (0.1, 1), (0.2, 1), (0.3, 2), (0.4, 2)])
def test_a_gain_is_delayed_to_the_sample_that_sees_it(delay, power):
    """At a sample the output shows what is held just after it."""
    held = zero_order_hold(control.ss([], [], [], [[3.0]]), 0.2, delay=delay)
    z = 0.8 * np.exp(0.5j)
    assert held(z) == pytest.approx(3.0 / z**power, rel=1e-13)


@pytest.mark.parametrize("dt", [0.0, -1.0, nan, inf])
def test_a_dt_that_is_not_positive_is_refused(dt):
    with pytest.raises(ValueError, match=f"dt = {dt!r}: expected a positive"):
        zero_order_hold(AXIS.system(), dt)


@pytest.mark.parametrize("delay", [-1e-9, -inf, nan, inf])
def test_a_delay_that_is_negative_or_not_finite_is_refused(delay):
    with pytest.raises(ValueError, match=f"delay = {delay!r}: expected a"):
        zero_order_hold(AXIS.system(), 0.1, delay=delay)


def test_a_delay_of_very_many_samples_is_refused():
    longest = zero_order_hold(Inertia(1.0).system(), 0.1, delay=MAX_DELAY * 0.1)
    assert longest.nstates == 2 + MAX_DELAY
    message = r"delay = 1e\+300 is 1e\+301 samples of dt = 0.1: expected at most 1000; use a larger"
    with pytest.raises(ValueError, match=message):
        zero_order_hold(Inertia(1.0).system(), 0.1, delay=1e300)
    with pytest.raises(ValueError, match="expected at most 1000"):
        zero_order_hold(Inertia(1.0).system(), 1e-300, delay=1e300)


@pytest.mark.parametrize(("name", "value"), [("dt", "0.1"), ("delay", "0"), ("delay", None)])
def test_what_is_no_number_is_refused(name, value):
    with pytest.raises(TypeError, match=f"{name} = {value!r}: expected a number"):
        zero_order_hold(AXIS.system(), **({"dt": 0.1, "delay": 0.0} | {name: value}))


def test_systems_that_cannot_be_held_are_refused():
    with pytest.raises(ValueError, match=r"improper transfer function: .*add the lag that makes"):
        zero_order_hold(control.tf([1.0, 0.0], [1.0]), 0.1)
    with pytest.raises(ValueError, match=r"sampled already, with dt = 0\.1: expected a continuous"):
        zero_order_hold(PID(1.0, 1.0, 1.0).sampled(0.1), 0.1)
    with pytest.raises(TypeError, match="got float: expected a python-control StateSpace"):
        zero_order_hold(3.0, 0.1)
    with pytest.raises(ValueError, match="system with nan in it: expected finite numbers"):
        zero_order_hold(control.ss([[nan]], [[1.0]], [[1.0]], [[0.0]]), 0.1)
    with pytest.raises(ValueError, match=r"within dt = 1000.0 the response leaves .*smaller dt"):
        zero_order_hold(control.ss([[2.0]], [[1.0]], [[1.0]], [[0.0]]), 1000.0)
