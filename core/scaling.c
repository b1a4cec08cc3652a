/* The units of a problem: powers of two in which its times are of order one, found from exponents
 * alone, so that problems that differ by powers of two become one and the same.
 *
 * The unit of time is about the longest of the times that distance, speeds and accelerations take
 * alone within each bound, or a duration asked for; that of distance the largest of what the state is worth in that time.
 * In these units a motion takes a few units of time. A bound far above all that such a motion can
 * reach never binds and is taken for none; a jerk 2^200 times what is needed for a change of the
 * acceleration within that time lets the acceleration jump.
 */
#include "task.h"

enum { NOTHING = -100000 };

#define FAR 1048576.0       /* 2^20: beyond all that is reached in a few units of time */
#define STEEPEST_ACCELERATION 1.3292279957849159e36 /* 2^120 */
#define STEEPEST_JERK 1.6069380442589903e60 /* 2^200 */
#define LARGEST 1.7976931348623157e308

static inline int most(int a, int b) { return a > b ? a : b; }

/* ceil(a / b) for b > 0 */
static inline int over(int a, int b) { return a >= 0 ? (a + b - 1) / b : -(-a / b); }

/* Exponent of the time that a quantity takes under a bound on its derivative n; both may be
 * absent. */
static inline int time_under(int quantity, double bound, int n) {
    if (quantity == NOTHING || !is_finite(bound) || bound == 0.0) {
        return NOTHING;
    }
    return over(quantity - exponent_of(bound), n);
}

static inline int exponent_or_nothing(double x) { return x == 0.0 ? NOTHING : exponent_of(x); }

static double in_units(double x, int exponent) { return is_finite(x) ? scaled(x, exponent) : x; }

static double none_if_far(double bound, double far) {
    return magnitude(bound) > far ? (bound > 0.0 ? INFINITE : -INFINITE) : bound;
}

static jounce_units own_units(const jounce_task *t, double duration) {
    double jerk = smaller(t->rise, t->fall), power = smaller(t->a_max, -t->a_min);
    double speed = larger(t->v_max, -t->v_min);
    int d = exponent_or_nothing(t->distance);
    int v = exponent_or_nothing(larger(magnitude(t->v0), magnitude(t->v1)));
    int a = exponent_or_nothing(larger(magnitude(t->a0), magnitude(t->a1)));
    jounce_units units;
    int time = time_under(a, jerk, 1);
    time = most(time, most(time_under(v, jerk, 2), time_under(v, power, 1)));
    time = most(time, most(time_under(d, jerk, 3), time_under(d, power, 2)));
    time = most(time, time_under(d, speed, 1));
    time = most(time, exponent_or_nothing(duration));
    if (time == NOTHING) {
        time = 0;
    }
    units.time = time;
    units.length = d;
    if (v != NOTHING) {
        units.length = most(units.length, v + time);
    }
    if (a != NOTHING) {
        units.length = most(units.length, a + 2 * time);
    }
    if (units.length == NOTHING) { /* nothing to do: `time` is zero, and the bound of order one */
        units.length = exponent_of(is_finite(jerk) ? jerk : power);
    }
    return units;
}

static void drop_far_bounds(jounce_task *t) {
    double steepest = larger(t->rise, t->fall), far;
    t->v_min = none_if_far(t->v_min, FAR);
    t->v_max = none_if_far(t->v_max, FAR);
    if (is_finite(steepest)) {
        double power = larger(larger(t->a_max, -t->a_min),
                              larger(magnitude(t->a0), magnitude(t->a1)));
        far = FAR * (1.0 + square_root(smaller(steepest, STEEPEST_JERK)));
        if (power < far && smaller(t->rise, t->fall) > STEEPEST_JERK * power) {
            t->rise = t->fall = INFINITE;
            t->a0 = t->a1 = 0.0;
        } else {
            t->a_min = none_if_far(t->a_min, far);
            t->a_max = none_if_far(t->a_max, far);
            t->rise = smaller(t->rise, STEEPEST_JERK);
            t->fall = smaller(t->fall, STEEPEST_JERK);
        }
    }
    if (!is_finite(t->rise)) {
        t->a_min = larger(t->a_min, -STEEPEST_ACCELERATION);
        t->a_max = smaller(t->a_max, STEEPEST_ACCELERATION);
    }
}

/* Whether 2^exponent is a normal number, so that products with it round once at most. */
static int is_normal(int exponent) { return exponent >= -1022 && exponent <= 1023; }

/* Multiply a number, which may be infinite, by 2^exponent, which is `factor` where normal. */
static inline double times(double x, int exponent, int normal, double factor) {
    return normal ? x * factor : in_units(x, exponent);
}

jounce_units jounce_to_own_units(jounce_task *task, double duration) {
    jounce_units units = own_units(task, duration);
    int x = -units.length, v = x + units.time, a = v + units.time, j = a + units.time;
    int normal = is_normal(x) && is_normal(v) && is_normal(a) && is_normal(j);
    double fx = power_of_two(x), fv = power_of_two(v), fa = power_of_two(a), fj = power_of_two(j);
    task->distance = times(task->distance, x, normal, fx);
    task->resolution = times(task->resolution, x, normal, fx);
    task->v0 = times(task->v0, v, normal, fv);
    task->v1 = times(task->v1, v, normal, fv);
    task->v_min = times(task->v_min, v, normal, fv);
    task->v_max = times(task->v_max, v, normal, fv);
    task->a0 = times(task->a0, a, normal, fa);
    task->a1 = times(task->a1, a, normal, fa);
    task->a_min = times(task->a_min, a, normal, fa);
    task->a_max = times(task->a_max, a, normal, fa);
    if (is_finite(task->rise)) { /* and stays so */
        task->rise = smaller(times(task->rise, j, normal, fj), LARGEST);
        task->fall = smaller(times(task->fall, j, normal, fj), LARGEST);
    }
    drop_far_bounds(task);
    return units;
}

jounce_task jounce_mirrored(const jounce_task *t) {
    jounce_task other = {-t->distance, -t->v0,    -t->a0,    -t->v1,  -t->a1,  -t->v_max,
                         -t->v_min,    -t->a_max, -t->a_min, t->rise, t->fall, t->resolution};
    return other;
}
