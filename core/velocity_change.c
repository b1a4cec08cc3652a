/* The fastest change of velocity and acceleration, wherever it ends.
 *
 * With jerk r to the peak and -f from it, kappa p^2 = v1 - v0 + a0^2/(2r) + a1^2/(2f) with
 * kappa = 1/(2r) + 1/(2f); a hold replaces what p lacks where it is bounded. Between accelerations
 * of one sign a straight ramp can be much shorter than any way round.
 */
#include "task.h"

static jounce_change by_rising(const jounce_task *t) {
    double a0 = t->a0, a1 = t->a1, v = t->v0, rising, falling;
    double rise_time = 1.0 / t->rise, fall_time = 1.0 / t->fall; /* of a unit of acceleration */
    double kappa = 0.5 * rise_time + 0.5 * fall_time;
    double square = (t->v1 - t->v0 + 0.5 * (a0 * a0 * rise_time + a1 * a1 * fall_time)) / kappa;
    double top = larger(a0, a1), peak = larger(square_root(larger(square, 0.0)), top);
    jounce_change change = {0};
    if (peak > t->a_max && t->a_max >= top) {
        change.hold = kappa * (square - t->a_max * t->a_max) / t->a_max;
        peak = t->a_max;
    }
    rising = (peak - a0) * rise_time;
    falling = (peak - a1) * fall_time;
    change.distance = ramp_in(&v, a0, peak, rising);
    change.distance += (v + 0.5 * peak * change.hold) * change.hold;
    v += peak * change.hold;
    change.distance += ramp_in(&v, peak, a1, falling);
    change.duration = rising + change.hold + falling;
    change.peak = peak;
    change.jerk = t->rise;
    change.back = -t->fall;
    return change;
}

jounce_change jounce_change_velocity(const jounce_task *t) {
    double gain = t->v1 - t->v0, jerk, back, straight, squares, v = t->v0;
    jounce_change change = {0};
    jounce_task mirrored;
    if (!is_finite(t->rise)) {
        change.peak = gain >= 0.0 ? t->a_max : t->a_min;
        change.hold = change.duration = gain / change.peak;
        change.distance = 0.5 * (t->v0 + t->v1) * change.hold;
        return change;
    }
    jerk = t->a1 >= t->a0 ? t->rise : -t->fall;
    back = t->a1 >= t->a0 ? -t->fall : t->rise;
    straight = 0.5 * (t->a1 - t->a0) * (t->a1 + t->a0) / jerk;
    squares = (t->a0 * t->a0 + t->a1 * t->a1) / smaller(t->rise, t->fall);
    if (magnitude(gain - straight) <=
        ROUNDING * (magnitude(t->v0) + magnitude(t->v1) + squares)) {
        change.duration = (t->a1 - t->a0) / jerk;
        change.distance = ramp(&v, t->a0, t->a1, jerk);
        change.peak = t->a1;
        change.jerk = jerk;
        change.back = back;
        return change;
    }
    if (gain > straight) {
        return by_rising(t);
    }
    mirrored = jounce_mirrored(t);
    change = by_rising(&mirrored);
    change.distance = -change.distance;
    change.peak = -change.peak;
    change.jerk = -change.jerk;
    change.back = -change.back;
    return change;
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
    double v = t->v0, peak = change->peak, hold = change->hold;
    if (!is_finite(t->rise)) {
        jounce_add(motion, hold, x, v, peak, 0.0);
        return;
    }
    jounce_add(motion, (peak - t->a0) / change->jerk, x, v, t->a0, change->jerk);
    x += ramp(&v, t->a0, peak, change->jerk);
    jounce_add(motion, hold, x, v, peak, 0.0);
    x += (v + 0.5 * peak * hold) * hold;
    v += peak * hold;
    jounce_add(motion, (t->a1 - peak) / change->back, x, v, peak, change->back);
}
