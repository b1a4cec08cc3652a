/* Transfers: the fastest motion between two states, the durations possible, and given ones. */
#include "task.h"

enum { MOST_EDGES = 128, MOST_ITERATIONS = 200 };

/* A transfer in its own units, its start brought inside. */
typedef struct {
    jounce_task whole, task; /* as asked, and what is left after the way inside */
    jounce_units units;
    double start, position, goal; /* of the whole, of the task, and the end */
    jounce_motion way;            /* inside */
} Problem;

/* --- the families of both bounds on the jerk and none ------------------------------------------ */

static int jumps(const jounce_family *f) { return !is_finite(f->task.rise); }

static void make_family(const jounce_task *task, jounce_family *f) {
    if (!is_finite(task->rise)) {
        jounce_speed_family(task, f);
    } else {
        jounce_jerk_family(task, f);
    }
}

static void solutions(const jounce_family *f, jounce_profiles *found) {
    if (jumps(f)) {
        jounce_speed_solutions(f, found);
    } else {
        jounce_jerk_solutions(f, found);
    }
}

static int lasting(const jounce_family *f, double duration, jounce_profile *profile) {
    return jumps(f) ? jounce_speed_lasting(f, duration, profile)
                       : jounce_jerk_lasting(f, duration, profile);
}

static int edges(const jounce_family *f, double *durations) {
    return jumps(f) ? jounce_speed_edges(f, durations) : jounce_jerk_edges(f, durations);
}

static double distance_of(const jounce_family *f, const jounce_profile *profile) {
    return jumps(f) ? jounce_speed_distance(f, profile) : jounce_jerk_distance(f, profile);
}

static void pieces_of(const jounce_family *f, const jounce_profile *profile, double start,
                      double end, jounce_motion *motion) {
    if (jumps(f)) {
        jounce_speed_pieces(f, profile, start, end, motion);
    } else {
        jounce_jerk_pieces(f, profile, start, end, motion);
    }
}

/* --- the fastest ------------------------------------------------------------------------------- */

static int shortest(const jounce_family *f, jounce_profile *best) {
    jounce_profiles found;
    int i, at = 0;
    if (!jumps(f)) {
        return jounce_jerk_shortest(f, best);
    }
    solutions(f, &found);
    for (i = 1; i < found.count; i++) {
        if (found.profiles[i].duration < found.profiles[at].duration) {
            at = i;
        }
    }
    if (found.count > 0) {
        *best = found.profiles[at];
    }
    return found.count > 0;
}

/* Add the fastest plan of a task; 0 where there is none.
 *
 * The quickest change from (v0, a0) to (v1, a1) covers a distance d. Where the durations of such
 * changes have no gap, which takes accelerations of one sign, the distances that can be covered
 * grow continuously from d both ways, and the sign of what is missing tells the family. */
static int fastest(const jounce_task *task, double start, double end, jounce_motion *motion) {
    int down = task->distance < jounce_change_velocity(task).distance, turn, any = 0, side = 0, k;
    jounce_task mirrored = jounce_mirrored(task);
    jounce_family family, best_family;
    jounce_profile profile, best = {0};
    for (k = 0; k < 2; k++) {
        turn = k == 0 ? down : !down;
        make_family(turn ? &mirrored : task, &family);
        if (shortest(&family, &profile) && (!any || profile.duration < best.duration)) {
            any = 1;
            side = turn;
            best = profile;
            best_family = family;
        }
        if (any && task->a0 * task->a1 <= 0.0) {
            break;
        }
    }
    if (!any) {
        return 0;
    }
    if (side) {
        int first = motion->count;
        pieces_of(&best_family, &best, -start, -end, motion);
        jounce_turn(motion, first);
    } else {
        pieces_of(&best_family, &best, start, end, motion);
    }
    return 1;
}

/* --- problems ---------------------------------------------------------------------------------- */

static void clear(jounce_motion *motion) {
    motion->count = 0;
    motion->duration = motion->inside_after = 0.0;
}

static void scale_up(const Problem *p, jounce_motion *motion) {
    int t = p->units.time, x = p->units.length, i, kept = 0;
    motion->duration = 0.0;
    for (i = 0; i < motion->count; i++) {
        jounce_piece piece = motion->pieces[i];
        piece.duration = scaled(piece.duration, t);
        piece.x = scaled(piece.x, x);
        piece.v = scaled(piece.v, x - t);
        piece.a = scaled(piece.a, x - 2 * t);
        piece.j = scaled(piece.j, x - 3 * t);
        motion->duration += piece.duration;
        if (piece.duration > 0.0) {
            motion->pieces[kept++] = piece;
        }
    }
    motion->count = kept;
    motion->inside_after = scaled(motion->inside_after, t);
}

static int in_range(const jounce_motion *motion) {
    int i;
    for (i = 0; i < motion->count; i++) {
        const jounce_piece *piece = &motion->pieces[i];
        if (!is_finite(piece->duration) || !is_finite(piece->x) || !is_finite(piece->v) ||
            !is_finite(piece->a) || !is_finite(piece->j)) {
            return 0;
        }
    }
    return is_finite(motion->duration) && is_finite(motion->end.x);
}

/* Scale a problem to its own units. */
static void pose(const jounce_state *start, const jounce_state *end, const jounce_limits *limits,
                 double size, Problem *p) {
    jounce_task *t = &p->whole;
    int jumps = !is_finite(limits->j_high);
    t->distance = end->x - start->x;
    t->v0 = start->v;
    t->a0 = jumps ? 0.0 : start->a;
    t->v1 = jounce_inside(end->v, limits->v_low, limits->v_high);
    t->a1 = jumps ? 0.0 : jounce_inside(end->a, limits->a_low, limits->a_high);
    t->v_min = limits->v_low;
    t->v_max = limits->v_high;
    t->a_min = limits->a_low;
    t->a_max = limits->a_high;
    t->fall = -limits->j_low;
    t->rise = limits->j_high;
    t->resolution = EPSILON * size;
    p->units = jounce_to_own_units(t);
    p->start = scaled(start->x, -p->units.length);
    p->goal = scaled(end->x, -p->units.length);
    clear(&p->way);
    p->task = *t;
}

static void bring_inside(Problem *p) {
    p->position = jounce_bring_inside(&p->task, p->start, &p->way);
    if (p->way.count > 0) {
        p->way.inside_after = jounce_time_inside(&p->whole, &p->way);
    }
}

static int starts_within(const jounce_task *t) {
    return t->v_min <= t->v0 && t->v0 <= t->v_max && t->a_min <= t->a0 && t->a0 <= t->a_max;
}

/* Scale a plan back to the caller's units; it ends at `end`. */
static jounce_status finish(const Problem *p, const jounce_state *end, const jounce_limits *limits,
                            jounce_motion *motion) {
    scale_up(p, motion);
    motion->end = *end;
    motion->end.v = jounce_inside(end->v, limits->v_low, limits->v_high);
    motion->end.a =
        is_finite(limits->j_high) ? jounce_inside(end->a, limits->a_low, limits->a_high) : 0.0;
    return in_range(motion) ? JOUNCE_OK : JOUNCE_RANGE;
}

static double size_of(const jounce_state *start, const jounce_state *end) {
    return larger(magnitude(start->x), magnitude(end->x));
}

jounce_status jounce_transfer(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, jounce_motion *motion) {
    return jounce_approach(start, end, limits, size_of(start, end), motion);
}

jounce_status jounce_approach(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, double size, jounce_motion *motion) {
    Problem p;
    pose(start, end, limits, size, &p);
    bring_inside(&p);
    clear(motion);
    if (p.way.count > 0 && starts_within(&p.whole)) { /* it leaves its bounds later, or never */
        if (fastest(&p.whole, p.start, p.goal, motion)) {
            return finish(&p, end, limits, motion);
        }
    }
    *motion = p.way;
    if (!fastest(&p.task, p.position, p.goal, motion)) {
        return JOUNCE_UNREACHABLE;
    }
    return finish(&p, end, limits, motion);
}

jounce_status jounce_velocity_transfer(const jounce_state *start, const jounce_state *end,
                                       const jounce_limits *limits, jounce_motion *motion) {
    jounce_state goal = *end;
    jounce_change change;
    Problem p;
    goal.x = start->x;
    pose(start, &goal, limits, magnitude(start->x), &p);
    clear(motion);
    p.position = jounce_bring_acceleration_inside(&p.task, p.start, motion);
    change = jounce_change_velocity(&p.task);
    if (jounce_change_leaves_bounds(&p.task, &change)) {
        return JOUNCE_UNREACHABLE;
    }
    jounce_change_pieces(&p.task, &change, p.position, motion);
    motion->inside_after = jounce_time_inside(&p.whole, motion);
    goal.x = scaled(p.position + change.distance, p.units.length);
    return finish(&p, &goal, limits, motion);
}

/* --- durations --------------------------------------------------------------------------------- */

/* Whether the task's distance can be covered in a duration. */
static int covers(const jounce_task *task, const jounce_family *up, const jounce_family *down,
                  double duration) {
    jounce_profile highest, lowest;
    return lasting(up, duration, &highest) && lasting(down, duration, &lowest) &&
           -distance_of(down, &lowest) <= task->distance &&
           task->distance <= distance_of(up, &highest);
}

static void sort(double *values, int count) {
    int i, j;
    for (i = 1; i < count; i++) {
        double value = values[i];
        for (j = i; j > 0 && values[j - 1] > value; j--) {
            values[j] = values[j - 1];
        }
        values[j] = value;
    }
}

static void add_interval(double low, double high, jounce_durations *out) {
    jounce_interval *last = &out->intervals[out->count - 1];
    if (out->count > 0 && low <= last->high * (1.0 + ROUNDING)) {
        last->high = high;
    } else if (out->count < JOUNCE_MOST_INTERVALS) {
        out->intervals[out->count].low = low;
        out->intervals[out->count++].high = high;
    }
}

static int is_among(double value, const double *values, int count) {
    int i;
    for (i = 0; i < count; i++) {
        if (values[i] == value) {
            return 1;
        }
    }
    return 0;
}

/* For a given duration the distances that can be covered are an interval, from the furthest down
 * to the furthest up, so that the possible durations change only where one of the two families
 * covers the task's distance, begins or ends. */
static void possible(const jounce_task *task, jounce_durations *out) {
    jounce_task mirrored = jounce_mirrored(task);
    jounce_family up, down;
    jounce_profiles found;
    double marks[MOST_EDGES], solved[2 * JOUNCE_MOST_PROFILES];
    int count, solutions_count = 0, i;
    make_family(task, &up);
    make_family(&mirrored, &down);
    out->count = 0;
    solutions(&up, &found);
    for (i = 0; i < found.count; i++) {
        solved[solutions_count++] = found.profiles[i].duration;
    }
    solutions(&down, &found);
    for (i = 0; i < found.count; i++) {
        solved[solutions_count++] = found.profiles[i].duration;
    }
    count = edges(&up, marks);
    count += edges(&down, marks + count);
    for (i = 0; i < solutions_count && count < MOST_EDGES - 1; i++) {
        marks[count++] = solved[i];
    }
    if (count == 0) {
        return;
    }
    sort(marks, count);
    marks[count] = 2.0 * marks[count - 1] + 1.0;
    for (i = 0; i < count; i++) {
        double left = marks[i], right = i + 1 < count ? marks[i + 1] : INFINITE;
        double middle = i + 1 < count ? 0.5 * (left + right) : marks[count];
        if (left == right) {
            continue;
        }
        if (covers(task, &up, &down, middle)) {
            add_interval(left, right, out);
        } else if (is_among(left, solved, solutions_count) &&
                   !(out->count > 0 && out->intervals[out->count - 1].high == left)) {
            add_interval(left, left, out);
        }
    }
}

jounce_status jounce_possible_durations(const jounce_state *start, const jounce_state *end,
                                        const jounce_limits *limits,
                                        jounce_durations *durations) {
    Problem p;
    int i;
    pose(start, end, limits, size_of(start, end), &p);
    bring_inside(&p);
    possible(&p.task, durations);
    for (i = 0; i < durations->count; i++) {
        jounce_interval *each = &durations->intervals[i];
        each->low = scaled(each->low + p.way.duration, p.units.time);
        each->high = scaled(each->high + p.way.duration, p.units.time);
    }
    return durations->count > 0 ? JOUNCE_OK : JOUNCE_UNREACHABLE;
}

/* --- plans of a given duration ------------------------------------------------------------------ */

typedef struct {
    jounce_task to, from; /* to the velocity kept, and from it to the end's */
    jounce_change first, last;
    double cruise, error; /* of the distance; NaN where the changes take too long */
} Cruise;

static double nan_value(void) { return INFINITE - INFINITE; }

static int is_nan(double x) { return x != x; }

static Cruise cruise_at(const jounce_task *task, double velocity, double duration) {
    Cruise c;
    c.to = c.from = *task;
    c.to.v1 = c.from.v0 = velocity;
    c.to.a1 = c.from.a0 = 0.0;
    c.first = jounce_change_velocity(&c.to);
    c.last = jounce_change_velocity(&c.from);
    c.cruise = duration - c.first.duration - c.last.duration;
    if (c.cruise < -ROUNDING * duration || jounce_change_leaves_bounds(&c.from, &c.last)) {
        c.error = nan_value();
    } else {
        c.error = c.first.distance + c.last.distance + velocity * c.cruise - task->distance;
    }
    return c;
}

/* The velocity reached when acceleration goes to zero as fast as it can. */
static double settling(double velocity, double acceleration, const jounce_task *task) {
    double jerk = acceleration > 0.0 ? task->fall : -task->rise;
    double gain = acceleration != 0.0 ? 0.5 * acceleration * acceleration / jerk : 0.0;
    return clamp(velocity + gain, task->v_min, task->v_max);
}

typedef struct {
    double velocity, error;
} Trial;

static Trial trial(const jounce_task *task, double velocity, double duration) {
    Trial result;
    result.velocity = velocity;
    result.error = cruise_at(task, velocity, duration).error;
    return result;
}

/* A velocity towards a bound at which the error has changed sign, or is not known. */
static Trial trial_towards(const jounce_task *task, double velocity, double bound, double duration) {
    double step = larger(magnitude(velocity), 1.0), before;
    int i;
    if (is_finite(bound)) {
        return trial(task, bound, duration);
    }
    step = bound > 0.0 ? step : -step;
    before = trial(task, velocity, duration).error;
    for (i = 0; i < 1000; i++) {
        if (!(trial(task, velocity + step, duration).error * before > 0.0)) {
            break;
        }
        step *= 2.0;
    }
    return trial(task, velocity + step, duration);
}

/* Where an increasing error is nearest to zero; at one end it may be NaN (far). */
static Trial bracketed(const jounce_task *task, double duration, Trial low, Trial high) {
    Trial best = low;
    int unknown_is_high = is_nan(high.error), k;
    if (is_nan(low.error) || magnitude(high.error) < magnitude(low.error)) {
        best = high;
    }
    for (k = 0; k < MOST_ITERATIONS; k++) {
        double middle = 0.5 * (low.velocity + high.velocity);
        Trial at;
        if (k % 3 != 0 && !is_nan(low.error + high.error) && high.error > low.error) {
            double secant = low.velocity - low.error * (high.velocity - low.velocity) /
                                               (high.error - low.error);
            if (low.velocity < secant && secant < high.velocity) {
                middle = secant;
            }
        }
        if (!(low.velocity < middle && middle < high.velocity)) {
            break;
        }
        at = trial(task, middle, duration);
        if (is_nan(at.error)) {
            if (unknown_is_high) {
                high = at;
            } else {
                low = at;
            }
            continue;
        }
        if (magnitude(at.error) < magnitude(best.error)) {
            best = at;
        }
        if (at.error == 0.0) {
            break;
        }
        if (at.error < 0.0) {
            low = at;
        } else {
            high = at;
        }
    }
    return best;
}

/* The velocity to cruise at so as to cover the distance in the duration; 0 where none suits. */
static int cruising_velocity(const jounce_task *task, double duration, double *velocity) {
    double speed = larger(magnitude(task->v0), magnitude(task->v1));
    double slack =
        task->resolution + 64.0 * ROUNDING * (magnitude(task->distance) + speed * duration);
    Trial nearest[2], low = {0, 0}, high = {0, 0}, best;
    int have_low = 0, have_high = 0, i;
    nearest[0] = trial(task, settling(task->v0, task->a0, task), duration);
    nearest[1] = trial(task, settling(task->v1, -task->a1, task), duration);
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
        low = trial_towards(task, high.velocity, task->v_min, duration);
    } else if (!have_high) {
        high = trial_towards(task, low.velocity, task->v_max, duration);
    }
    if (is_nan(low.error) && is_nan(high.error)) {
        return 0;
    }
    best = bracketed(task, duration, low, high);
    *velocity = best.velocity;
    return magnitude(best.error) <= slack;
}

static int by_cruising(const jounce_task *task, double duration, double start, double end,
                       jounce_motion *motion) {
    double velocity;
    Cruise c;
    if (!cruising_velocity(task, duration, &velocity)) {
        return 0;
    }
    c = cruise_at(task, velocity, duration);
    jounce_change_pieces(&c.to, &c.first, start, motion);
    jounce_add(motion, c.cruise, start + c.first.distance, velocity, 0.0, 0.0);
    jounce_change_pieces(&c.from, &c.last, end - c.last.distance, motion);
    return 1;
}

/* Go on by a time within a piece. */
static void go_on(jounce_piece *piece, double time) {
    double x[4];
    x[0] = piece->x;
    x[1] = piece->v;
    x[2] = piece->a;
    x[3] = piece->j;
    piece->duration -= time;
    piece->x = jounce_taylor(x, 3, 0, time);
    piece->v = jounce_taylor(x, 3, 1, time);
    piece->a = jounce_taylor(x, 3, 2, time);
}

/* Add the motion weight first + (1 - weight) second. */
static void add_mean(const jounce_motion *first, const jounce_motion *second, double weight,
                     jounce_motion *motion) {
    double w = 1.0 - weight;
    jounce_piece one, other;
    int i = 0, k = 0;
    if (first->count == 0 || second->count == 0) {
        return;
    }
    one = first->pieces[0];
    other = second->pieces[0];
    for (;;) {
        double t = one.duration <= other.duration * (1.0 + ROUNDING) ? one.duration
                                                                     : other.duration;
        int one_ends = one.duration <= t * (1.0 + ROUNDING);
        int other_ends = other.duration <= t * (1.0 + ROUNDING);
        jounce_add(motion, t, weight * one.x + w * other.x, weight * one.v + w * other.v,
                   weight * one.a + w * other.a, weight * one.j + w * other.j);
        if ((one_ends && ++i >= first->count) || (other_ends && ++k >= second->count)) {
            return;
        }
        if (one_ends) {
            one = first->pieces[i];
        } else {
            go_on(&one, t);
        }
        if (other_ends) {
            other = second->pieces[k];
        } else {
            go_on(&other, t);
        }
    }
}

/* A weighted mean of the motions that go furthest up and furthest down in a time, which keeps
 * every bound as they do. */
static int by_mean(const jounce_task *task, double duration, double start, jounce_motion *motion) {
    jounce_task mirrored = jounce_mirrored(task);
    jounce_profile highest, lowest;
    jounce_motion above, below;
    jounce_family up, down;
    double top, bottom, slack, weight;
    make_family(task, &up);
    make_family(&mirrored, &down);
    if (!lasting(&up, duration, &highest) || !lasting(&down, duration, &lowest)) {
        return 0;
    }
    top = distance_of(&up, &highest);
    bottom = -distance_of(&down, &lowest);
    slack = up.blur + 16.0 * ROUNDING * (magnitude(top) + magnitude(bottom) + duration);
    if (task->distance < bottom - slack || task->distance > top + slack) {
        return 0;
    }
    weight = top > bottom ? (task->distance - bottom) / (top - bottom) : 1.0;
    clear(&above);
    clear(&below);
    pieces_of(&up, &highest, start, start + top, &above);
    pieces_of(&down, &lowest, -start, -start - bottom, &below);
    jounce_turn(&below, 0);
    add_mean(&above, &below, clamp(weight, 0.0, 1.0), motion);
    return 1;
}

jounce_status jounce_transfer_lasting(const jounce_state *start, const jounce_state *end,
                                      const jounce_limits *limits, double duration,
                                      jounce_motion *motion) {
    Problem p;
    double left;
    pose(start, end, limits, size_of(start, end), &p);
    bring_inside(&p);
    left = scaled(duration, -p.units.time) - p.way.duration;
    *motion = p.way;
    if (!by_cruising(&p.task, left, p.position, p.goal, motion)) {
        *motion = p.way;
        if (!by_mean(&p.task, left, p.position, motion)) {
            return JOUNCE_NO_DURATION;
        }
    }
    return finish(&p, end, limits, motion);
}
