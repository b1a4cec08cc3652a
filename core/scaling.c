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

enum { NOTHING = -100000, LEAST = -20000 }; /* exponents below the least are of nothing, too */

#define FAR 1048576.0       /* 2^20: beyond all that is reached in a few units of time */
#define STEEPEST_ACCELERATION 1.3292279957849159e36 /* 2^120 */
#define STEEPEST_JERK 1.6069380442589903e60 /* 2^200 */
#define LARGEST 1.7976931348623157e308

static inline int most(int a, int b) { return a > b ? a : b; }

/* ceil(a / b) for b > 0, of exponents: from far below, which needs no look at a sign */
static inline int over(int a, int b) {
    return (int)((unsigned)(a + 100000 * b + b - 1) / (unsigned)b) - 100000;
}

/* The exponent of a size; of one that is zero or infinite `other`. */
static inline int exponent_or(double size, int other) {
    jounce_bits value;
    int exponent;
    value.number = size;
    exponent = (int)(value.bits >> 52);
    if (exponent - 1 >= 0 && exponent < 2047) {
        return exponent - 1022;
    }
    return size == 0.0 || !is_finite(size) ? other : exponent_of(size);
}

static inline double largest_of(double a, double b) { return larger(magnitude(a), magnitude(b)); }

static double in_units(double x, int exponent) { return is_finite(x) ? scaled(x, exponent) : x; }

static double none_if_far(double bound, double far) {
    return magnitude(bound) > far ? (bound > 0.0 ? INFINITE : -INFINITE) : bound;
}

/* Exponents of the times that quantities take under bounds on their derivatives. */
static jounce_units own_units(const jounce_task *t, double duration) {
    int jerk = exponent_or(smaller(t->rise, t->fall), -NOTHING);
    int power = exponent_or(smaller(t->a_max, -t->a_min), -NOTHING);
    int speed = exponent_or(larger(t->v_max, -t->v_min), -NOTHING);
    int d = exponent_or(magnitude(t->distance), NOTHING);
    int v = exponent_or(largest_of(t->v0, t->v1), NOTHING);
    int a = exponent_or(largest_of(t->a0, t->a1), NOTHING);
    jounce_units units;
    int time = most(most(a - jerk, v - power), most(over(v - jerk, 2), over(d - jerk, 3)));
    time = most(time, most(most(over(d - power, 2), d - speed), exponent_or(duration, NOTHING)));
    if (time < LEAST) {
        time = 0;
    }
    units.time = time;
    units.length = most(d, most(v + time, a + 2 * time));
    if (units.length < LEAST) { /* nothing to do: `time` is zero, and the bound of order one */
        units.length = jerk < -LEAST ? jerk : power;
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
        far = power < FAR ? FAR : FAR * (1.0 + square_root(smaller(steepest, STEEPEST_JERK)));
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

/* Multiply by powers of two that are normal numbers. */
static void scale(jounce_task *t, double x, double v, double a, double j) {
    t->distance *= x;
    t->resolution *= x;
    t->v0 *= v;
    t->v1 *= v;
    t->v_min *= v;
    t->v_max *= v;
    t->a0 *= a;
    t->a1 *= a;
    t->a_min *= a;
    t->a_max *= a;
    t->rise *= j;
    t->fall *= j;
}

/* Multiply by any powers of two. */
static void scale_far(jounce_task *t, int x, int v, int a, int j) {
    t->distance = in_units(t->distance, x);
    t->resolution = in_units(t->resolution, x);
    t->v0 = in_units(t->v0, v);
    t->v1 = in_units(t->v1, v);
    t->v_min = in_units(t->v_min, v);
    t->v_max = in_units(t->v_max, v);
    t->a0 = in_units(t->a0, a);
    t->a1 = in_units(t->a1, a);
    t->a_min = in_units(t->a_min, a);
    t->a_max = in_units(t->a_max, a);
    t->rise = in_units(t->rise, j);
    t->fall = in_units(t->fall, j);
}

jounce_units jounce_to_own_units(jounce_task *task, double duration) {
    jounce_units units = own_units(task, duration);
    int x = -units.length, v = x + units.time, a = v + units.time, j = a + units.time;
    int jerks_are_bounded = is_finite(task->rise);
    if (is_normal(x) && is_normal(v) && is_normal(a) && is_normal(j)) {
        scale(task, normal_power(x), normal_power(v), normal_power(a), normal_power(j));
    } else {
        scale_far(task, x, v, a, j);
    }
    if (jerks_are_bounded) { /* and stay so */
        task->rise = smaller(task->rise, LARGEST);
        task->fall = smaller(task->fall, LARGEST);
    }
    drop_far_bounds(task);
    return units;
}

jounce_task jounce_mirrored(const jounce_task *t) {
    jounce_task other = {-t->distance, -t->v0,    -t->a0,    -t->v1,  -t->a1,  -t->v_max,
                         -t->v_min,    -t->a_max, -t->a_min, t->rise, t->fall, t->resolution};
    return other;
}
