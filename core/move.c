/* Moves: from rest to rest, in closed form where the bounds are the same in both directions.
 *
 * With bounds V, A, W on velocity, acceleration and jerk, t_w = A/W (Thompson, Sections II, III):
 *
 *     V reached:      T = R/V + t_v,    t_v = t_w + V/A if A is reached on the way, else
 *                                       t_v = 2 sqrt(V/W);
 *     only A reached: T = t_w + sqrt(t_w^2 + 4 R/A);
 *     neither:        T = (32 R/W)^(1/3).
 *
 * Without a bound on the jerk t_w = 0, and without one on the acceleration the velocity jumps. The
 * second half mirrors the first: x(t) = R - x(T - t). Bounds that differ between directions are
 * those of a transfer.
 */
#include "task.h"

/* How a move of positive distance goes: ramps of the jerk, a hold, a cruise. */
typedef struct {
    double ramp, hold, cruise; /* of half of the change of velocity: ramp, hold, ramp */
    double peak_a, peak_v;
} Shape;

static double reached_or(double bound, double value) { return smaller(bound, value); }

/* Up to V: ramps of the acceleration, a hold between. */
static Shape to_velocity(double v, double a, double w) {
    double t_w = is_finite(w) ? a / w : 0.0;
    Shape s = {0};
    s.peak_v = v;
    if (!is_finite(a) && !is_finite(w)) {
        return s;
    }
    if (is_finite(a) && a * t_w <= v) {
        s.ramp = t_w;
        s.hold = v / a - t_w;
        s.peak_a = a;
    } else {
        s.ramp = square_root(v / w);
        s.peak_a = reached_or(a, square_root(v * w));
    }
    return s;
}

static double ramps_of(const Shape *s) { return 2.0 * s->ramp + s->hold; }

static Shape shape(double distance, double v, double a, double w) {
    double t_w;
    Shape s;
    if (is_finite(v)) {
        s = to_velocity(v, a, w);
        if (distance >= v * ramps_of(&s)) {
            s.cruise = distance / v - ramps_of(&s);
            return s;
        }
    }
    s.cruise = s.hold = 0.0;
    t_w = is_finite(w) ? a / w : 0.0;
    if (is_finite(a) && distance >= 2.0 * a * t_w * t_w) {
        double root = square_root(t_w * t_w + 4.0 * distance / a);
        s.ramp = t_w;
        s.hold = larger(2.0 * (distance / a - t_w * t_w * 2.0) / (root + 3.0 * t_w), 0.0);
        s.peak_a = a;
        s.peak_v = reached_or(v, a * (s.hold + t_w));
    } else {
        s.ramp = cube_root(0.5 * distance / w);
        s.peak_a = reached_or(a, w * s.ramp);
        s.peak_v = reached_or(v, w * s.ramp * s.ramp);
    }
    return s;
}

static int moderate(double x) {
    return x == INFINITE || (x > 1e-60 && x < 1e60);
}

static int is_closed(double distance, const jounce_limits *l) {
    return l->v_low == -l->v_high && l->a_low == -l->a_high && l->j_low == -l->j_high &&
           moderate(magnitude(distance)) && moderate(l->v_high) && moderate(l->a_high) &&
           moderate(l->j_high);
}

/* Ramp up, hold, and, where the move cruises, ramp to the velocity. Without a cruise the two inner
 * ramps are one piece, which add_mirrored leaves out. */
static void add_half(const Shape *s, double jerk, jounce_motion *m) {
    double t = s->ramp, x = 0.0, v = 0.0, a = s->peak_a;
    if (t > 0.0) {
        jounce_add(m, t, x, v, 0.0, jerk);
        x = jerk * t * t * t / 6.0;
        v = 0.5 * a * t;
    }
    jounce_add(m, s->hold, x, v, a, 0.0);
    x += (v + 0.5 * a * s->hold) * s->hold;
    v += a * s->hold;
    if (t > 0.0) {
        jounce_add(m, s->cruise > 0.0 ? t : 2.0 * t, x, v, a, -jerk);
    }
    jounce_add(m, s->cruise, 0.5 * s->peak_v * ramps_of(s), s->peak_v, 0.0, 0.0);
}

static void add_mirrored(const Shape *s, double distance, double jerk, jounce_motion *m) {
    double t = s->ramp, a = s->peak_a, x = s->peak_v * (0.5 * ramps_of(s)), v = s->peak_v;
    if (t > 0.0) {
        if (s->cruise > 0.0) {
            jounce_add(m, t, distance - x, v, 0.0, -jerk);
        }
        x = jerk * t * t * t / 6.0 + 0.5 * a * t * s->hold + 0.5 * a * s->hold * s->hold;
        v = 0.5 * a * t + a * s->hold;
    }
    jounce_add(m, s->hold, distance - x, v, -a, 0.0);
    if (t > 0.0) {
        jounce_add(m, t, distance - jerk * t * t * t / 6.0, 0.5 * a * t, -a, jerk);
    }
}

/* Without bounds of acceleration and jerk: all of the distance at one velocity. */
static jounce_status glide(double distance, const jounce_limits *l, jounce_motion *m) {
    double v = distance > 0.0 ? l->v_high : l->v_low;
    jounce_add(m, distance / v, 0.0, v, 0.0, 0.0);
    return is_finite(m->duration) ? JOUNCE_OK : JOUNCE_RANGE;
}

jounce_status jounce_move(double distance, const jounce_limits *limits, jounce_motion *motion) {
    jounce_state start = {0.0, 0.0, 0.0}, end = {distance, 0.0, 0.0};
    double size = magnitude(distance), jerk = limits->j_high;
    Shape s;
    motion->count = 0;
    motion->duration = motion->inside_after = 0.0;
    motion->end = end;
    if (distance == 0.0) {
        return JOUNCE_OK;
    }
    if (!is_finite(limits->a_high) && !is_finite(limits->j_high)) {
        return glide(distance, limits, motion);
    }
    if (!is_closed(distance, limits)) {
        return jounce_transfer(&start, &end, limits, motion);
    }
    s = shape(size, limits->v_high, limits->a_high, limits->j_high);
    if (s.ramp > 0.0) {
        jerk = smaller(jerk, s.peak_a / s.ramp);
    } else {
        jerk = 0.0;
    }
    add_half(&s, jerk, motion);
    add_mirrored(&s, size, jerk, motion);
    if (distance < 0.0) {
        jounce_turn(motion, 0);
    }
    return JOUNCE_OK;
}

/* Its duration alone; NaN where there is none. */
double jounce_move_duration(double distance, const jounce_limits *limits) {
    jounce_motion motion;
    if (is_closed(distance, limits) && (is_finite(limits->a_high) || is_finite(limits->j_high))) {
        Shape s = shape(magnitude(distance), limits->v_high, limits->a_high, limits->j_high);
        return 2.0 * ramps_of(&s) + s.cruise;
    }
    return jounce_move(distance, limits, &motion) == JOUNCE_OK ? motion.duration
                                                               : INFINITE - INFINITE;
}
