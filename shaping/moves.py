"""Rest-to-rest moves in minimum time, and Thompson's perfect splines."""

from __future__ import annotations

from math import inf

from .checks import finite, one_of, positive, whole
from .limits import Limits
from .pieces import MAX_ORDER
from .plain_moves import OPTIMAL, Method, formed_move, move_at_once
from .rise import spline_divisor, spline_rise, to_trajectory
from .trajectory import Trajectory, point, within_range


def min_time_move(
    distance: float,
    limits: Limits,
    *,
    start: float = 0.0,
    method: Method = OPTIMAL,
    duration: float | None = None,
    round_to: float | None = None,
    rtol: float = 1e-4,
) -> Trajectory:
    """Return the move from rest to rest within limits in minimum time, or in a given one.

    Parameters
    ----------
    distance : float
        Signed distance, in the limits' distance unit. Zero gives a trajectory of duration zero.
    limits : Limits
        Bounds on any of the derivatives 1…n, n ≤ 14, each the same in both directions or not,
        absent or zero on a side, and on position; the highest one drives the move.
    start : float, optional
        Position at the start.
    method : "optimal" or "closed-form", optional
        "closed-form" is the fastest feasible one of: the perfect spline, the recursive S-curve,
        recursive S-curves whose innermost ramps are perfect splines, Thompson's longer moves;
        `proven_excess` says at once how much it loses at most, `certify` how much.
        "optimal" (default) is that or, from n = 4, a linear program's motion where it is faster.
    duration : float, optional
        How long the move is to take, the minimum at least. It then needs the smallest share of
        the bound on the highest derivative: to rounding for n ≤ 3, on a grid above. With
        "closed-form" the fastest move is slowed down as a whole from n = 4 on, x(t) → x(t/c),
        which divides derivative k by c^k.
    round_to : float, optional
        Sample time: the duration is rounded up to a whole number of samples.
    rtol : float, optional
        How near to the proven minimum the duration is to come, relative, where bounds differ
        between the directions and n ≥ 4.

    Returns
    -------
    Trajectory
        Of order n, starting at time 0.

    Raises
    ------
    InfeasibleError
        Where a bound on position or one that is zero on a side leaves no motion; for a duration
        below the minimum, which it names.
    ValueError
        For a distance or start that is not finite, an unknown method, an order above 14, a
        bound that is missing in the direction that the move needs, or a duration outside the
        range of a double.

    Warns
    -----
    RuntimeWarning
        Where "optimal" has to return the closed form: an order above 10, or limits so many
        decades apart that the linear program fails; and where the search ends before `rtol` is
        reached.

    Notes
    -----
    Where bounds on even derivatives are the same in both directions, "optimal" maximises x(T/2)
    over piecewise-constant x^(n) with |x^(k)| ≤ L_k at all times and x^(k)(T/2) = 0 for even
    k ≥ 2, and mirrors that half. With bounds active below the highest the exact optimum may switch
    infinitely often (Wang & Hu): what is returned comes near it.

    For n ≤ 3, and wherever only the highest derivative binds (a perfect spline), both methods
    give the minimum time. For n ≥ 4 with lower bounds active the closed forms can miss it: on the
    22 problems of order 4 to 6 in tests/data/minimum_time.json, whose minimum is known from
    rigorous bounds, by at most 1.1 % (n = 4), 12 % (n = 5) and 8.4 % (n = 6), "optimal" by at
    most 0.01 %; `certify` proves how near it is. It takes 20 to 120 ms at orders 4 to 6, half a
    second at orders 8 to 10 and some seconds with limits many decades apart, a closed form less
    than one millisecond, one to nine by order where bounds differ between directions. Closed
    forms change smoothly with their limits, moves of "optimal" to within their gap only.

    Bounds that differ between directions are used exactly, those on even derivatives from n = 4 to
    10 by programs over the whole horizon as in `min_time_transfer`. Closed forms, from n = 4 on,
    are there the faster one of moving averages of the move of order 1, 2 or 3 and of those for the
    smaller magnitude of each pair from acceleration upward: feasible, but not the fastest.

    End position within 1e-12 of the distance (and rounding of start + distance), every bound
    kept to 1e-12 relative, for orders to 10.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Sections II to IV; Pourkavoos, "Piecewise Polynomials
    with Bounded Derivatives", 2023; Lambrechts, 2005; Biagiotti & Melchiorri; Wang & Hu, arXiv
    2311.07039 and 2403.17675.

    Examples
    --------
    >>> move = min_time_move(32.0, Limits(jerk=1.0))
    >>> move.duration
    10.079...
    >>> move.peak("jerk")
    1.0
    >>> min_time_move(32.0, Limits(jerk=1.0), round_to=0.25).duration
    10.25
    """
    if method is not OPTIMAL:
        one_of("method", method, ("optimal", "closed-form"))
    if duration is None and round_to is None:
        at_once = move_at_once(distance, limits, start)
        if at_once is not None:
            return at_once
    if isinstance(limits, Limits) and not (limits.plain and (limits.order < 4 or limits.symmetric)):
        from .general_moves import general_move

        found_move = general_move(distance, limits, start, (duration, round_to), method, rtol)
        if found_move is not None:
            return found_move
    if duration is not None or round_to is not None:
        from .lasting import move_lasting

        fastest_move = min_time_move(distance, limits, start=start, method=method)
        return move_lasting(fastest_move, limits, duration, round_to, gentlest=method == "optimal")
    return formed_move(distance, limits, start, method)


def perfect_spline(distance: float, order: int, bound: float, *, start: float = 0.0) -> Trajectory:
    """Return the minimum-time move with nothing but derivative `order` bounded.

        R = D·Tⁿ / ((n−1)!·4^(n−1)),   switches at T·sin²(kπ/(2n)),   x^(n) = ±D alternating

    Parameters
    ----------
    distance : float
        Signed distance R.
    order : int
        The bounded derivative n, 1 to 40.
    bound : float
        Its bound D > 0.
    start : float, optional
        Position at the start.

    Returns
    -------
    Trajectory
        Of order n, starting at time 0.

    Raises
    ------
    ValueError
        For an order outside 1…40, a bound that is not positive and finite, or a distance or
        start that is not finite.

    Notes
    -----
    Positions to 1e-15 of the distance for n ≤ 10 where the machine has extended precision.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV, Table 1.
    """
    distance, start = finite("distance", distance), finite("start", start)
    order, bound = whole("order", order, 1, MAX_ORDER), positive("bound", bound)
    if distance == 0.0:
        return point(start, order)
    move = within_range(lambda: _positive_spline(abs(distance), order, bound))
    return (move if distance > 0.0 else move.mirror()).shift(start)


def bound_for_rise_time(acceleration: float, rise_time: float, order: int) -> float:
    """Return the bound on the highest derivative that gives acceleration a rise time.

        D = A·(m−1)!·4^(m−1) / t_r^m,   m = n − 2

    The ramp 0 → A of acceleration is a perfect spline of order m, so a rise time can be given
    in place of the highest bound: `Limits` with this D, the acceleration and perhaps a velocity
    give Thompson's "longer moves".

    Parameters
    ----------
    acceleration : float
        A > 0, in distance/time².
    rise_time : float
        t_r > 0, from zero to full acceleration.
    order : int
        The derivative n ≥ 3 to be bounded (6 for pop).

    Returns
    -------
    float
        D in distance/timeⁿ.

    Raises
    ------
    ValueError
        For an order outside 3…40, or a value that is not positive and finite.

    References
    ----------
    Thompson, "Snap, Crackle, and Pop", Section IV: for pop, A = 0.2 deg/s² and t_r = 1 s,
    D = 76.8 deg/s⁶.

    Examples
    --------
    >>> round(bound_for_rise_time(0.2, 1.0, 6), 9)
    76.8
    """
    acceleration = positive("acceleration", acceleration)
    rise_time = positive("rise_time", rise_time)
    order = whole("order", order, 3, MAX_ORDER)
    try:
        power = rise_time ** (order - 2)
    except OverflowError:
        power = inf
    bound = acceleration * spline_divisor(order - 2) / power if power else inf
    if not 0.0 < bound < inf:
        raise ValueError(
            f"rise_time = {rise_time!r}: the bound on derivative {order} leaves the range of a "
            "double; choose other units"
        )
    return bound


def _positive_spline(distance: float, order: int, bound: float) -> Trajectory:
    span = (distance / bound * spline_divisor(order)) ** (1.0 / order)
    return to_trajectory(spline_rise(order, span, distance, bound))
