/* Starts beyond their bounds, or bound to leave them, are brought inside first.
 *
 * The policy, in this order:
 *
 * 1. An acceleration beyond its bound goes to the bound as fast as the jerk allows.
 * 2. One that is about to carry the velocity out, or further out, goes to zero likewise.
 * 3. A velocity beyond its bound goes to the bound in the least time that arrives there with zero
 *    acceleration, so that the motion can cruise at the bound and never swings past it: braking on
 *    at full deceleration would cross the bound sooner, but turn an axis round that should only
 *    slow down. Where the acceleration leads further than the bound whatever is done, it goes to
 *    the velocity that it leads to.
 * 4. Where the end is too near for that, brake harder: as hard as the bounds allow as far as the
 *    bound of the velocity, or to level off at a lower velocity; the way that arrives first without
 *    turning the axis round. Where that cannot be avoided the first of all three arrives: full
 *    deceleration is no help where it takes long to get rid of.
 *
 * What remains is an ordinary problem from a state inside the bounds.
 */
#include "task.h"

enum { MOST_HALVINGS = 200 };

double jounce_inside(double value, double low, double high) {
    if (high < value && value <= high + ROUNDING * magnitude(high)) {
        return high;
    }
    if (low > value && value >= low - ROUNDING * magnitude(low)) {
        return low;
    }
    return value;
}

/* Go to acceleration `end` as fast as the jerk allows. */
static void turn_acceleration(jounce_task *t, double end, double *x, jounce_motion *motion) {
    double jerk = end > t->a0 ? t->rise : -t->fall, v = t->v0, step;
    if (end == t->a0) {
        return;
    }
    jounce_add(motion, (end - t->a0) / jerk, *x, v, t->a0, jerk);
    step = ramp(&v, t->a0, end, jerk);
    *x += step;
    t->distance -= step;
    t->v0 = v;
    t->a0 = end;
}

static jounce_change change_to(const jounce_task *t, double velocity) {
    jounce_task to = *t;
    to.v1 = velocity;
    to.a1 = 0.0;
    return jounce_change_velocity(&to);
}

/* How much further than the end a motion goes that levels off at a velocity and then changes to
 * the end's. */
static double excess(const jounce_task *t, double velocity) {
    jounce_task from = *t;
    from.v0 = velocity;
    from.a0 = 0.0;
    return change_to(t, velocity).distance + jounce_change_velocity(&from).distance - t->distance;
}

/* The velocity at which to level off, at most `top`. */
static double level(const jounce_task *t, double top) {
    double settling = t->v1, low = t->v_min, high = top;
    double slack = t->resolution + 64.0 * ROUNDING * (magnitude(t->distance) + magnitude(t->v0));
    int i;
    if (excess(t, top) <= slack) {
        return top;
    }
    if (t->a1 != 0.0 && is_finite(t->rise)) { /* before the acceleration of the end builds up */
        settling -= 0.5 * t->a1 * t->a1 / (t->a1 > 0.0 ? t->rise : -t->fall);
    }
    settling = clamp(settling, low, top);
    if (excess(t, settling) <= slack) {
        low = settling;
    } else {
        high = settling;
        if (!is_finite(low)) {
            double step = larger(1.0, magnitude(high));
            for (i = 0, low = high - step; i < 1000 && excess(t, low) > 0.0; i++) {
                step *= 2.0;
                low = high - step;
            }
        }
        if (excess(t, low) > 0.0) {
            return low;
        }
    }
    for (i = 0; i < MOST_HALVINGS; i++) {
        double middle = 0.5 * (low + high);
        if (!(low < middle && middle < high)) {
            break;
        }
        if (excess(t, middle) <= 0.0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static void move_on(jounce_task *t, double duration, double j, double *x, jounce_motion *motion) {
    double h = duration, step = (t->v0 + (0.5 * t->a0 + j * h / 6.0) * h) * h;
    if (h > 0.0) {
        jounce_add(motion, h, *x, t->v0, t->a0, j);
        *x += step;
        t->distance -= step;
        t->v0 += (t->a0 + 0.5 * j * h) * h;
        t->a0 += j * h;
    }
}

/* Down to v_max as fast as possible: fall, hold, and rise where v_min would be passed else.
 * Falling, v = summit - a^2/(2 fall); the last rise follows v = v_min + a^2/(2 rise). */
static void brake_hard(jounce_task *t, double *x, jounce_motion *motion) {
    double rise = t->rise, fall = t->fall, bound = t->v_max, least = t->a_min;
    double summit = t->v0 + 0.5 * t->a0 * t->a0 / fall;
    double arrival = -square_root(2.0 * fall * larger(summit - bound, 0.0));
    double gentlest = -square_root(2.0 * rise * (bound - t->v_min)); /* more passes v_min */
    double lowest;
    if (arrival >= larger(least, gentlest)) {
        move_on(t, (t->a0 - arrival) / fall, -fall, x, motion);
        t->a0 = arrival;
    } else if (least >= gentlest) {
        move_on(t, (t->a0 - least) / fall, -fall, x, motion);
        t->a0 = least;
        move_on(t, (bound - t->v0) / least, 0.0, x, motion);
    } else {
        lowest = smaller(-square_root((summit - t->v_min) / (0.5 / rise + 0.5 / fall)), t->a0);
        move_on(t, (t->a0 - larger(lowest, least)) / fall, -fall, x, motion);
        if (lowest < least) {
            double gap = summit - 0.5 * least * least / fall -
                         (t->v_min + 0.5 * least * least / rise);
            t->a0 = lowest = least;
            move_on(t, -gap / least, 0.0, x, motion);
        }
        move_on(t, (gentlest - lowest) / rise, rise, x, motion);
        t->a0 = gentlest;
    }
    t->v0 = bound;
}

static void level_off(jounce_task *t, double velocity, double *x, jounce_motion *motion) {
    jounce_task to = *t;
    jounce_change change;
    to.v1 = velocity;
    to.a1 = 0.0;
    change = jounce_change_velocity(&to);
    jounce_change_pieces(&to, &change, *x, motion);
    *x += change.distance;
    t->distance -= change.distance;
    t->resolution += ROUNDING * larger(magnitude(t->v0), magnitude(velocity)) * change.duration;
    t->v0 = velocity;
    t->a0 = 0.0;
}

static void brake(jounce_task *t, double velocity, int hard, double *x, jounce_motion *motion) {
    if (hard) {
        brake_hard(t, x, motion);
    } else {
        level_off(t, velocity, x, motion);
    }
}

/* Whether a plan goes backwards. */
static int goes_back(const jounce_motion *plan, double slack) {
    int i;
    for (i = 0; i < plan->count; i++) {
        const jounce_piece *p = &plan->pieces[i];
        double h = p->duration, at = p->j != 0.0 ? -p->a / p->j : 0.0;
        double v = p->v + (p->a + 0.5 * p->j * h) * h;
        if (0.0 < at && at < h) {
            v = smaller(v, p->v + 0.5 * p->a * at);
        }
        if (v < -slack) {
            return 1;
        }
    }
    return 0;
}

/* How a way to brake turns out: whether the axis turns round on its way to an end that does not, and
 * how long all takes. */
typedef struct {
    int turns;
    double duration;
} Outcome;

static Outcome outcome_of(const jounce_task *task, double velocity, int hard, double x) {
    Outcome outcome = {1, INFINITE};
    jounce_task t = *task;
    jounce_motion plan;
    jounce_clear(&plan);
    brake(&t, velocity, hard, &x, &plan);
    if (jounce_fastest(&t, x, x + t.distance, &plan)) {
        outcome.turns = t.v1 >= 0.0 && goes_back(&plan, 1e-12 * magnitude(t.v_max));
        outcome.duration = plan.duration;
    }
    return outcome;
}

static int is_better(Outcome a, Outcome b) {
    return a.turns < b.turns || (a.turns == b.turns && a.duration < b.duration);
}

/* From above v_max. */
static void slow_down(jounce_task *t, double *x, jounce_motion *motion) {
    double top = t->v_max, velocity;
    int hard = 0;
    if (is_finite(t->rise) && t->a0 < 0.0) {
        top = smaller(top, larger(t->v0 - 0.5 * t->a0 * t->a0 / t->rise, t->v_min));
    }
    velocity = is_finite(t->rise) ? level(t, top) : top; /* order 2 brakes on from there */
    if (velocity != top) {
        Outcome lower = outcome_of(t, velocity, 0, *x), at_top = outcome_of(t, top, 0, *x);
        if (is_better(at_top, lower)) {
            velocity = top;
            lower = at_top;
        }
        hard = is_better(outcome_of(t, velocity, 1, *x), lower);
    }
    brake(t, velocity, hard, x, motion);
}

/* Whether the acceleration carries the velocity over a bound until it can be zero. */
static int is_carried_out(const jounce_task *t) {
    double gained = 0.5 * t->a0 * t->a0 / (t->a0 > 0.0 ? t->fall : t->rise);
    double slack = ROUNDING * (magnitude(t->v0) + gained);
    return (t->a0 > 0.0 && t->v0 + gained > t->v_max + slack) ||
           (t->a0 < 0.0 && t->v0 - gained < t->v_min - slack);
}

double jounce_bring_acceleration_inside(jounce_task *t, double x, jounce_motion *motion) {
    t->v0 = jounce_inside(t->v0, t->v_min, t->v_max);
    t->a0 = jounce_inside(t->a0, t->a_min, t->a_max);
    if (is_finite(t->rise)) {
        turn_acceleration(t, clamp(t->a0, t->a_min, t->a_max), &x, motion);
    }
    return x;
}

double jounce_bring_inside(jounce_task *t, double x, jounce_motion *motion) {
    jounce_task other;
    if (jounce_starts_within(t) && !is_carried_out(t)) {
        return x;
    }
    x = jounce_bring_acceleration_inside(t, x, motion);
    if (is_finite(t->rise) && is_carried_out(t)) {
        turn_acceleration(t, 0.0, &x, motion);
    }
    t->v0 = jounce_inside(t->v0, t->v_min, t->v_max);
    if (t->v0 > t->v_max) {
        slow_down(t, &x, motion);
    } else if (t->v0 < t->v_min) {
        int first = motion->count;
        double turned = -x;
        other = jounce_mirrored(t);
        slow_down(&other, &turned, motion);
        jounce_turn(motion, first);
        *t = jounce_mirrored(&other);
        x = -turned;
    }
    return x;
}

/* Whether the velocity, or else the acceleration, keeps its bounds, but for a relative slack. */
static int keeps(const jounce_task *t, int of_v, double value, double slack) {
    double more = 1.0 + slack;
    return (of_v ? t->v_min : t->a_min) * more <= value &&
           value <= (of_v ? t->v_max : t->a_max) * more;
}

/* Velocity or acceleration at a time in a piece. */
static double value_at(const jounce_piece *piece, int of_v, double h) {
    return of_v ? piece->v + (piece->a + 0.5 * piece->j * h) * h : piece->a + piece->j * h;
}

/* The last time in a piece, in which v is monotone, at which one of both is out of its bounds; 0 for
 * none. Where it ends at the bound that it was out of, it is so until the end. */
static double last_out_of(const jounce_task *t, const jounce_piece *piece, int of_v) {
    double h = piece->duration, low = 0.0, high = h;
    double low_bound = of_v ? t->v_min : t->a_min, high_bound = of_v ? t->v_max : t->a_max;
    int i;
    if (!keeps(t, of_v, value_at(piece, of_v, h), ROUNDING)) {
        return h;
    }
    if (keeps(t, of_v, value_at(piece, of_v, 0.0), ROUNDING)) {
        return 0.0;
    }
    if (value_at(piece, of_v, 0.0) > 0.0 ? value_at(piece, of_v, h) >= high_bound * (1.0 - ROUNDING)
                                         : value_at(piece, of_v, h) <= low_bound * (1.0 - ROUNDING)) {
        return h;
    }
    for (i = 0; i < MOST_HALVINGS; i++) {
        double middle = 0.5 * (low + high);
        if (!(low < middle && middle < high)) {
            break;
        }
        if (keeps(t, of_v, value_at(piece, of_v, middle), 0.0)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

static double last_outside(const jounce_task *t, const jounce_piece *piece) {
    return larger(last_out_of(t, piece, 1), last_out_of(t, piece, 0));
}

double jounce_time_inside(const jounce_task *t, const jounce_motion *motion) {
    double begun = 0.0, after = 0.0;
    int i;
    for (i = 0; i < motion->count; i++) { /* from the front, where short ramps keep their digits */
        jounce_piece first = motion->pieces[i], second = first;
        double turn = -first.a / first.j, outside = 0.0; /* where v turns */
        if (0.0 < turn && turn < first.duration) {
            second.duration -= turn;
            second.v += 0.5 * first.a * turn;
            second.a = 0.0;
            first.duration = turn;
            outside = last_outside(t, &second);
            outside += outside > 0.0 ? turn : 0.0;
        }
        if (outside == 0.0) {
            outside = last_outside(t, &first);
        }
        if (outside > 0.0) {
            after = begun + outside;
        }
        begun += motion->pieces[i].duration;
    }
    return after;
}
