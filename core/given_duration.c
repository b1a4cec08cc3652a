/* Transfers of a given duration: to one velocity, along at it, and to the end's; or a weighted mean
 * of the motions that go furthest up and furthest down in this time.
 */
#include "task.h"

enum { MOST_ITERATIONS = 200 };

#define STEEP 1.5692754338466701e57 /* 2^190: scaling.c cuts jerks off not far above */

typedef struct {
    jounce_task to, from; /* to the velocity kept, and from it to the end's */
    jounce_change first, last;
    double cruise, error; /* of the distance; NaN where the changes take too long */
} Cruise;

static double nan_value(void) { return INFINITE - INFINITE; }

static int is_nan(double x) { return x != x; }

/* What does not depend on the velocity kept. */
static void begin_cruise(const jounce_task *task, Cruise *c) {
    c->to = c->from = *task;
    c->to.a1 = c->from.a0 = 0.0;
}

static void cruise_at(Cruise *c, double velocity, double duration) {
    c->to.v1 = c->from.v0 = velocity;
    c->first = jounce_change_velocity(&c->to);
    c->last = jounce_change_velocity(&c->from);
    c->cruise = duration - c->first.duration - c->last.duration;
    if (c->cruise < -ROUNDING * duration || jounce_change_leaves_bounds(&c->from, &c->last)) {
        c->error = nan_value();
    } else {
        c->error =
            c->first.distance + c->last.distance + velocity * c->cruise - c->to.distance;
    }
}

/* The velocity reached when acceleration goes to zero as fast as it can. */
static double settling(double velocity, double acceleration, const jounce_task *task) {
    double jerk = acceleration > 0.0 ? task->fall : -task->rise;
    double gain = acceleration != 0.0 ? 0.5 * acceleration * acceleration / jerk : 0.0;
    return clamp(velocity + gain, task->v_min, task->v_max);
}

/* A velocity, the distance's error and its derivatives by the velocity: a higher one shifts all that
 * is between the two outer ramps. */
typedef struct {
    double velocity, error, slope, bend;
} Trial;

/* How the time of a ramp between the peak and zero grows with the velocity that the change goes to. */
static double growth(const jounce_change *change, double ramp, double kappa) {
    return change->hold > 0.0 ? 0.0 : 0.5 * ramp / (kappa * change->peak * magnitude(change->peak));
}

static Trial trial(Cruise *c, double velocity, double duration) {
    const jounce_change *first = &c->first, *last = &c->last;
    Trial result;
    cruise_at(c, velocity, duration);
    result.velocity = velocity;
    result.error = c->error;
    result.slope = c->cruise;
    result.bend = 1.0 / last->peak - 1.0 / first->peak;
    if (is_finite(c->to.rise)) {
        double kappa = 0.5 / c->to.rise + 0.5 / c->to.fall;
        double back = -first->peak / first->back, forth = last->peak / last->jerk;
        result.slope += 0.5 * (back + forth);
        result.bend += 0.5 * (growth(first, back, kappa) - growth(last, forth, kappa));
    }
    return result;
}

/* A velocity towards a bound at which the error has changed sign, or is not known. */
static Trial trial_towards(Cruise *c, Trial from, double bound, double duration) {
    double step = larger(magnitude(from.velocity), 1.0);
    Trial at;
    int i;
    if (is_finite(bound)) {
        return trial(c, bound, duration);
    }
    step = bound > 0.0 ? step : -step;
    for (i = 0; i < 1000; i++) {
        at = trial(c, from.velocity + step, duration);
        if (!(at.error * from.error > 0.0)) {
            break;
        }
        step *= 2.0;
    }
    return at;
}

/* How far it is to where a quadratic is zero, or a line where that has none. */
static double step_from(Trial at) {
    double square = at.slope * at.slope - 2.0 * at.error * at.bend;
    double root = square_root(larger(square, 0.0));
    return square > 0.0 ? -2.0 * at.error / (at.slope + root) : -at.error / at.slope;
}

/* Where an increasing error is nearest to zero; at one end it may be NaN (far). Steps to the zero of
 * a quadratic, each of which leaves an error of third order; where one leaves the bracket, and now
 * and then, it is bisected. */
static Trial bracketed(Cruise *c, double duration, double noise, Trial low, Trial high) {
    Trial best = low, at;
    int unknown_is_high = is_nan(high.error), is_last = 0, k;
    double following, step;
    if (is_nan(low.error) || magnitude(high.error) < magnitude(low.error)) {
        best = high;
    }
    step = step_from(best);
    following = best.velocity + step;
    for (k = 0; k < MOST_ITERATIONS && magnitude(best.error) > noise; k++) {
        double moved = step;
        if (!(low.velocity < following && following < high.velocity) || k % 8 == 7) {
            following = 0.5 * (low.velocity + high.velocity);
            if (!(low.velocity < following && following < high.velocity)) {
                break;
            }
        }
        at = trial(c, following, duration);
        if (magnitude(at.error) < magnitude(best.error)) {
            best = at;
        } else if (magnitude(best.error) <= 64.0 * noise) { /* rounding allows no more */
            break;
        }
        if (is_last && magnitude(best.error) <= 64.0 * noise) {
            break;
        }
        if (is_nan(at.error) ? unknown_is_high : at.error >= 0.0) {
            high = at;
        } else {
            low = at;
        }
        if (is_nan(at.error)) {
            at = best;
        }
        step = step_from(at);
        following = at.velocity + step;
        moved = step / moved;
        is_last = magnitude(at.error * moved * moved * moved) <= noise;
    }
    return best;
}

/* Find the velocity to cruise at so as to cover the distance in the duration; 0 where none suits. */
static int find_cruise(const jounce_task *task, double duration, Cruise *c) {
    double speed = larger(magnitude(task->v0), magnitude(task->v1));
    double size = magnitude(task->distance) + speed * duration;
    double slack = task->resolution + 64.0 * ROUNDING * size, settled;
    Trial nearest[2], low = {0.0, 0.0, 0.0, 0.0}, high = low, best;
    int have_low = 0, have_high = 0, i;
    begin_cruise(task, c);
    nearest[0] = trial(c, settling(task->v0, task->a0, task), duration);
    nearest[1] = trial(c, settling(task->v1, -task->a1, task), duration);
    settled = larger(magnitude(nearest[0].velocity), magnitude(nearest[1].velocity));
    for (i = 0; i < 2; i++) {
        Trial at = nearest[i];
        if (is_nan(at.error)) {
            continue;
        }
        if (at.error <= 0.0 && (!have_low || at.velocity > low.velocity)) {
            low = at;
            have_low = 1;
        }
        if (at.error >= 0.0 && (!have_high || at.velocity < high.velocity)) {
            high = at;
            have_high = 1;
        }
    }
    if (!have_low && !have_high) {
        return 0;
    }
    if (!have_low) {
        low = trial_towards(c, high, task->v_min, duration);
    } else if (!have_high) {
        high = trial_towards(c, low, task->v_max, duration);
    }
    if (is_nan(low.error) && is_nan(high.error)) {
        return 0;
    }
    best = bracketed(c, duration, 0.125 * EPSILON * size, low, high);
    if (c->to.v1 != best.velocity) {
        cruise_at(c, best.velocity, duration);
    }
    slack += 64.0 * ROUNDING * settled * (c->first.duration + c->last.duration);
    return magnitude(best.error) <= slack;
}

static int by_cruising(const jounce_task *task, double duration, double start, double end,
                       jounce_motion *motion) {
    Cruise c;
    if (!find_cruise(task, duration, &c)) {
        return 0;
    }
    jounce_change_pieces(&c.to, &c.first, start, motion);
    jounce_add(motion, c.cruise, start + c.first.distance, c.from.v0, 0.0, 0.0);
    jounce_change_pieces(&c.from, &c.last, end - c.last.distance, motion);
    return 1;
}

/* --- weighted means ------------------------------------------------------------------------- */

/* Where two motions of one duration stand: their pieces, and the time gone within each. */
typedef struct {
    const jounce_motion *of[2];
    double weight;
    int at[2];
    double gone[2];
} Pair;

/* The time until a piece ends, and whose does. */
static double next_break(const Pair *p, int *ends) {
    double left[2], t;
    int k;
    for (k = 0; k < 2; k++) {
        left[k] = p->of[k]->pieces[p->at[k]].duration - p->gone[k];
    }
    t = left[0] <= left[1] * (1.0 + ROUNDING) ? left[0] : left[1];
    for (k = 0; k < 2; k++) {
        ends[k] = left[k] <= t * (1.0 + ROUNDING);
    }
    return t;
}

static void walk(Pair *p, double t, const int *ends, int step) {
    int k;
    for (k = 0; k < 2; k++) {
        p->at[k] += ends[k] ? step : 0;
        p->gone[k] = ends[k] ? 0.0 : p->gone[k] + t;
    }
}

/* Add what a piece has reached after a time, times a weight. */
static void weigh(jounce_piece *sum, const jounce_piece *piece, double time, double weight) {
    double x[4];
    x[0] = piece->x;
    x[1] = piece->v;
    x[2] = piece->a;
    x[3] = piece->j;
    sum->x += weight * jounce_taylor(x, 3, 0, time);
    sum->v += weight * jounce_taylor(x, 3, 1, time);
    sum->a += weight * jounce_taylor(x, 3, 2, time);
    sum->j += weight * piece->j;
}

/* The mean of the two pieces, from the times `begun` in each on. */
static jounce_piece mean_of(const Pair *p, const double *begun, double duration) {
    jounce_piece sum = {0.0, 0.0, 0.0, 0.0, 0.0};
    weigh(&sum, &p->of[0]->pieces[p->at[0]], begun[0], p->weight);
    weigh(&sum, &p->of[1]->pieces[p->at[1]], begun[1], 1.0 - p->weight);
    sum.duration = duration;
    return sum;
}

static void add_piece(jounce_motion *motion, const jounce_piece *p) {
    jounce_add(motion, p->duration, p->x, p->v, p->a, p->j);
}

/* The mean of the pieces that end last, seen from the end, where `gone` are the times from there. */
static jounce_piece mean_before(const Pair *p, double t, const int *ends) {
    double begun[2];
    int k;
    for (k = 0; k < 2; k++) {
        begun[k] = ends[k] ? 0.0 : p->of[k]->pieces[p->at[k]].duration - p->gone[k] - t;
    }
    return mean_of(p, begun, t);
}

/* Add the motion weight first + (1 - weight) second: from the front until both go on for long, then
 * from the end back to there, as ramps at either end may be shorter than what rounding leaves of
 * the duration. 0 where the two do not meet. */
static int add_mean(const Pair *start, double duration, jounce_motion *motion) {
    Pair front = *start, back = *start;
    jounce_piece last[JOUNCE_MOST_PIECES], middle;
    int ends[2], count = 0, total = front.of[0]->count + front.of[1]->count;
    double left = duration, t;
    back.at[0] = back.of[0]->count - 1;
    back.at[1] = back.of[1]->count - 1;
    while ((t = next_break(&front, ends)) * total < duration) {
        middle = mean_of(&front, front.gone, t);
        add_piece(motion, &middle);
        walk(&front, t, ends, 1);
        left -= t;
        if (front.at[0] > back.at[0] || front.at[1] > back.at[1]) {
            return 0;
        }
    }
    while (back.at[0] + back.at[1] > front.at[0] + front.at[1]) {
        t = next_break(&back, ends);
        last[count++] = mean_before(&back, t, ends);
        walk(&back, t, ends, -1);
        left -= t;
        if (back.at[0] < front.at[0] || back.at[1] < front.at[1]) {
            return 0;
        }
    }
    middle = mean_of(&front, front.gone, left);
    add_piece(motion, &middle);
    while (count > 0) {
        add_piece(motion, &last[--count]);
    }
    return 1;
}

/* A weighted mean of the motions that go furthest up and furthest down in a time, which keeps
 * every bound as they do. */
static int by_mean(const jounce_task *task, double duration, double start, jounce_motion *motion) {
    jounce_profile highest, lowest;
    jounce_motion above, below;
    jounce_family up, down;
    Pair pair = {{&above, &below}, 0.0, {0, 0}, {0.0, 0.0}};
    double top, bottom, slack;
    up.task = *task;
    down.task = jounce_mirrored(task);
    jounce_make_family(&up);
    jounce_make_family(&down);
    if (!jounce_lasting(&up, duration, &highest) || !jounce_lasting(&down, duration, &lowest)) {
        return 0;
    }
    if (larger(magnitude(highest.duration - duration), magnitude(lowest.duration - duration)) >
        64.0 * ROUNDING * duration) {
        return 0;
    }
    top = jounce_distance_of(&up, &highest);
    bottom = -jounce_distance_of(&down, &lowest);
    slack = jounce_blur(&up) + 16.0 * ROUNDING * (magnitude(top) + magnitude(bottom) + duration);
    if (task->distance < bottom - slack || task->distance > top + slack) {
        return 0;
    }
    pair.weight = top > bottom ? clamp((task->distance - bottom) / (top - bottom), 0.0, 1.0) : 1.0;
    jounce_clear(&above);
    jounce_clear(&below);
    jounce_pieces_of(&up, &highest, start, start + top, &above);
    jounce_pieces_of(&down, &lowest, -start, -start - bottom, &below);
    jounce_turn(&below, 0);
    if (above.count == 0 || below.count == 0) { /* it is there, and has no time */
        return 1;
    }
    return add_mean(&pair, duration, motion);
}

/* Whether the start's acceleration is beyond its bounds, and beside the duration its way inside takes
 * less time than numbers hold, although it may lead far. */
static int jumps_inside(const jounce_state *start, const jounce_limits *limits,
                        const jounce_task *whole) {
    return (start->a < limits->a_low || start->a > limits->a_high) && is_finite(limits->j_high) &&
           smaller(whole->rise, whole->fall) > STEEP;
}

jounce_status jounce_transfer_lasting(const jounce_state *start, const jounce_state *end,
                                      const jounce_limits *limits, double duration,
                                      jounce_motion *motion) {
    jounce_problem p;
    double left;
    jounce_pose(start, end, limits, jounce_size_of_positions(start, end), duration, &p);
    if (p.status != JOUNCE_OK) {
        return p.status;
    }
    if (jumps_inside(start, limits, &p.whole)) {
        return JOUNCE_RANGE;
    }
    jounce_start_inside(&p);
    left = scaled(duration, -p.units.time) - p.way.duration;
    jounce_begin_with(&p.way, motion);
    if (!by_cruising(&p.task, left, p.position, p.goal, motion)) {
        jounce_begin_with(&p.way, motion);
        if (!by_mean(&p.task, left, p.position, motion)) {
            return JOUNCE_NO_DURATION;
        }
    }
    return jounce_finish(&p, end, limits, motion);
}
