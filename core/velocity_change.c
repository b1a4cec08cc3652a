/* The fastest change of velocity and acceleration, wherever it ends.
 *
 * With jerk r to the peak and -f from it, kappa p^2 = v1 - v0 + a0^2/(2r) + a1^2/(2f) with
 * kappa = 1/(2r) + 1/(2f); a hold replaces what p lacks where it is bounded. Between accelerations
 * of one sign a straight ramp can be much shorter than any way round.
 */
#include "task.h"

/* How far the peak lies above an acceleration at an end, where the other half of the change has time
 * `half` of a unit of squared acceleration: without the digits that a slow jerk does not touch. */
static double above(double peak, double a, double gain, double other, double half, double kappa) {
    double squares = (other - a) * (other + a) * half;
    const double ways[] = {peak - a, larger((gain + squares) / (kappa * (peak + a)), 0.0)};
    return ways[a > 0.0];
}

/* To a peak and back, in the direction `sign`, all seen in it. */
static jounce_change to_peak(const jounce_task *t, int is_up) {
    const double signs[] = {-1.0, 1.0}, jerks[] = {t->fall, t->rise}, most[] = {-t->a_min, t->a_max};
    double sign = signs[is_up], rise = jerks[is_up], fall = jerks[!is_up], bound = most[is_up];
    double a0 = sign * t->a0, a1 = sign * t->a1, v0 = sign * t->v0, v1 = sign * t->v1;
    double gain = v1 - v0, top = larger(a0, a1), peak, first, last, middle, distance;
    double per_rise = 1.0 / rise, per_fall = 1.0 / fall;
    double half_rise = 0.5 * per_rise, half_fall = 0.5 * per_fall, kappa = half_rise + half_fall;
    double square = (gain + a0 * a0 * half_rise + a1 * a1 * half_fall) / kappa;
    jounce_change change = {0};
    peak = larger(square_root(larger(square, 0.0)), top);
    if (peak > bound && bound >= top) {
        peak = bound;
        first = peak - a0;
        last = peak - a1;
        gain -= first * (peak + a0) * half_rise + last * (peak + a1) * half_fall;
        change.hold = larger(gain, 0.0) / peak;
    } else {
        first = above(peak, a0, gain, a1, half_fall, kappa);
        last = above(peak, a1, gain, a0, half_rise, kappa);
    }
    change.first = first / rise;
    change.last = last / fall;
    change.duration = change.first + change.hold + change.last;
    distance = ramp_in(&v0, a0, peak, change.first) - ramp_in(&v1, a1, peak, -change.last);
    middle = magnitude(v0) <= magnitude(v1) ? v0 + 0.5 * peak * change.hold
                                            : v1 - 0.5 * peak * change.hold;
    change.distance = sign * (distance + middle * change.hold);
    change.peak = sign * peak;
    change.jerk = sign * rise;
    change.back = -sign * fall;
    return change;
}

jounce_change jounce_change_velocity(const jounce_task *t) {
    const double jerks[] = {-t->fall, t->rise};
    double gain = t->v1 - t->v0, jerk, per_jerk, straight, squares, v = t->v0;
    int is_up;
    jounce_change change = {0};
    if (!is_finite(t->rise)) {
        change.peak = gain >= 0.0 ? t->a_max : t->a_min;
        change.hold = change.duration = gain / change.peak;
        change.distance = 0.5 * (t->v0 + t->v1) * change.hold;
        return change;
    }
    is_up = t->a1 >= t->a0;
    jerk = jerks[is_up];
    per_jerk = 1.0 / jerk;
    straight = 0.5 * (t->a1 - t->a0) * (t->a1 + t->a0) * per_jerk;
    squares = (t->a0 * t->a0 + t->a1 * t->a1) * magnitude(per_jerk);
    if (magnitude(gain - straight) <=
        ROUNDING * (magnitude(t->v0) + magnitude(t->v1) + squares)) {
        change.first = change.duration = (t->a1 - t->a0) / jerk;
        change.distance = ramp(&v, t->a0, t->a1, jerk);
        change.peak = t->a1;
        change.jerk = jerk;
        change.back = jerks[!is_up];
        return change;
    }
    return to_peak(t, gain > straight);
}

int jounce_change_leaves_bounds(const jounce_task *t, const jounce_change *change) {
    double turn, slack;
    if (change->peak * t->a1 >= 0.0) {
        return 0;
    }
    turn = t->v1 - 0.5 * t->a1 * t->a1 / change->back;
    slack = ROUNDING * (magnitude(turn) + magnitude(t->v1));
    return turn < t->v_min - slack || turn > t->v_max + slack;
}

void jounce_change_pieces(const jounce_task *t, const jounce_change *change, double x,
                          jounce_motion *motion) {
    double v = t->v0, w = t->v1, peak = change->peak, hold = change->hold, end;
    if (!is_finite(t->rise)) {
        jounce_add(motion, hold, x, v, peak, 0.0);
        return;
    }
    jounce_add(motion, change->first, x, v, t->a0, change->jerk);
    end = x + change->distance + ramp_in(&w, t->a1, peak, -change->last);
    x += ramp_in(&v, t->a0, peak, change->first);
    jounce_add(motion, hold, x, v, peak, 0.0);
    jounce_add(motion, change->last, end, w, peak, change->back);
}
