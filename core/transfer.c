/* Transfers: the fastest motion between two states, and the fastest change of velocity. */
#include "task.h"

/* The fastest profile of a task, or of the mirrored one. */
typedef struct {
    jounce_family families[2]; /* of the task and the mirrored one, as far as they were needed */
    jounce_profile profile;
    int turned;
} Fastest;

/* The quickest change from (v0, a0) to (v1, a1) covers a distance d. Where the durations of such
 * changes have no gap, which takes accelerations of one sign, the distances that can be covered
 * grow continuously from d both ways, and the sign of what is missing tells the family. */
static int find_fastest(const jounce_task *task, Fastest *fastest) {
    double begins = jounce_change_velocity(task).distance;
    const double both[] = {begins, -begins};
    int down = task->distance < begins, any = 0, k;
    jounce_profile profile;
    fastest->families[0].task = *task;
    fastest->families[1].task = jounce_mirrored(task);
    for (k = 0; k < 2; k++) {
        int turn = down ^ k;
        jounce_family *family = &fastest->families[turn];
        jounce_make_family(family);
        if (jounce_shortest(family, k == 0 ? both[down] : INFINITE, &profile) &&
            (!any || profile.duration < fastest->profile.duration)) {
            any = 1;
            fastest->turned = turn;
            fastest->profile = profile;
        }
        if (any && task->a0 * task->a1 <= 0.0) {
            break;
        }
    }
    return any;
}

int jounce_fastest(const jounce_task *task, double start, double end, jounce_motion *motion) {
    int first = motion->count;
    Fastest fastest;
    if (!find_fastest(task, &fastest)) {
        return 0;
    }
    if (fastest.turned) {
        jounce_pieces_of(&fastest.families[1], &fastest.profile, -start, -end, motion);
        jounce_turn(motion, first);
    } else {
        jounce_pieces_of(&fastest.families[0], &fastest.profile, start, end, motion);
    }
    return 1;
}

/* --- problems ---------------------------------------------------------------------------------- */

void jounce_clear(jounce_motion *motion) {
    motion->count = 0;
    motion->duration = motion->inside_after = 0.0;
}

void jounce_begin_with(const jounce_motion *way, jounce_motion *motion) {
    int i;
    motion->count = way->count;
    motion->duration = way->duration;
    motion->inside_after = way->inside_after;
    for (i = 0; i < way->count; i++) {
        motion->pieces[i] = way->pieces[i];
    }
}

static void scale_up(const jounce_problem *p, jounce_motion *motion) {
    int t = p->units.time, x = p->units.length, i, kept = 0;
    int normal = t > -300 && t < 300 && x > -300 && x < 300;
    double ft = 1.0, fx = 1.0, fv = 1.0, fa = 1.0, fj = 1.0;
    if (normal) {
        ft = power_of_two(t);
        fx = power_of_two(x);
        fv = power_of_two(x - t);
        fa = power_of_two(x - 2 * t);
        fj = power_of_two(x - 3 * t);
    }
    motion->duration = 0.0;
    for (i = 0; i < motion->count; i++) {
        jounce_piece piece = motion->pieces[i];
        piece.duration = normal ? piece.duration * ft : scaled(piece.duration, t);
        piece.x = (normal ? piece.x * fx : scaled(piece.x, x)) + p->offset;
        piece.v = normal ? piece.v * fv : scaled(piece.v, x - t);
        piece.a = normal ? piece.a * fa : scaled(piece.a, x - 2 * t);
        piece.j = normal ? piece.j * fj : scaled(piece.j, x - 3 * t);
        motion->duration += piece.duration;
        if (piece.duration > 0.0) {
            motion->pieces[kept++] = piece;
        }
    }
    motion->count = kept;
    motion->inside_after = scaled(motion->inside_after, t);
}

/* Differences of infinities and of NaN to themselves are NaN, all others zero. */
static int in_range(const jounce_motion *motion) {
    double sum = motion->duration + motion->end.x;
    int i;
    sum -= sum;
    for (i = 0; i < motion->count; i++) {
        const jounce_piece *p = &motion->pieces[i];
        sum += (p->x - p->x) + (p->v - p->v) + (p->a - p->a) + (p->j - p->j);
    }
    return sum == 0.0;
}

/* Whether the end keeps the bounds, at a distance that doubles hold. */
static jounce_status status_of(const jounce_task *t) {
    int within = t->v_min <= t->v1 && t->v1 <= t->v_max && t->a_min <= t->a1 && t->a1 <= t->a_max;
    if (!is_finite(t->distance)) {
        return JOUNCE_RANGE;
    }
    return within ? JOUNCE_OK : JOUNCE_UNREACHABLE;
}

/* Scale a problem to its own units. */
void jounce_pose(const jounce_state *start, const jounce_state *end, const jounce_limits *limits,
                 double size, double duration, jounce_problem *p) {
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
    p->status = status_of(t);
    p->units = jounce_to_own_units(t, duration);
    p->start = scaled(start->x, -p->units.length);
    p->goal = scaled(end->x, -p->units.length);
    p->offset = 0.0;
    if (!is_finite(p->start) || !is_finite(p->goal)) {
        p->offset = start->x;
        p->start = p->goal = 0.0;
    }
    jounce_clear(&p->way);
    p->task = *t;
}

void jounce_start_inside(jounce_problem *p) {
    p->position = jounce_bring_inside(&p->task, p->start, &p->way);
    if (p->way.count > 0) {
        p->way.inside_after = jounce_time_inside(&p->whole, &p->way);
    }
}

/* Scale a plan back to the caller's units; it ends at `end`. */
jounce_status jounce_finish(const jounce_problem *p, const jounce_state *end, const jounce_limits *limits,
                            jounce_motion *motion) {
    const jounce_task *t = &p->whole;
    scale_up(p, motion);
    if (motion->count > 0) { /* reckoned from the end it may be off by rounding */
        motion->pieces[0].x = scaled(p->start, p->units.length);
        motion->pieces[0].v = scaled(jounce_inside(t->v0, t->v_min, t->v_max),
                                     p->units.length - p->units.time);
    }
    motion->end = *end;
    motion->end.v = jounce_inside(end->v, limits->v_low, limits->v_high);
    motion->end.a =
        is_finite(limits->j_high) ? jounce_inside(end->a, limits->a_low, limits->a_high) : 0.0;
    return in_range(motion) ? JOUNCE_OK : JOUNCE_RANGE;
}

double jounce_size_of_positions(const jounce_state *start, const jounce_state *end) {
    return larger(magnitude(start->x), magnitude(end->x));
}

jounce_status jounce_transfer(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, jounce_motion *motion) {
    return jounce_approach(start, end, limits, jounce_size_of_positions(start, end), motion);
}

/* Plan a problem whose start has been brought inside. */
static jounce_status plan_from_inside(const jounce_problem *p, const jounce_state *end,
                                      const jounce_limits *limits, jounce_motion *motion) {
    jounce_clear(motion);
    if (p->way.count > 0 && jounce_starts_within(&p->whole)) { /* it leaves its bounds later, or never */
        if (jounce_fastest(&p->whole, p->start, p->goal, motion)) {
            return jounce_finish(p, end, limits, motion);
        }
    }
    jounce_begin_with(&p->way, motion);
    if (!jounce_fastest(&p->task, p->position, p->goal, motion)) {
        return JOUNCE_UNREACHABLE;
    }
    return jounce_finish(p, end, limits, motion);
}

jounce_status jounce_approach(const jounce_state *start, const jounce_state *end,
                              const jounce_limits *limits, double size, jounce_motion *motion) {
    jounce_problem p;
    jounce_pose(start, end, limits, size, 0.0, &p);
    if (p.status != JOUNCE_OK) {
        return p.status;
    }
    jounce_start_inside(&p);
    return plan_from_inside(&p, end, limits, motion);
}

/* --- times alone -------------------------------------------------------------------------------- */

/* Whether nothing leaves the range of a double in the caller's units, whatever the plan. */
static int is_ordinary(const jounce_problem *p) {
    int t = p->units.time, x = p->units.length;
    return t > -64 && t < 64 && x > -64 && x < 64 && p->offset == 0.0 &&
           larger(magnitude(p->start), magnitude(p->goal)) < 1e200;
}

/* The same sums as of whole pieces. */
static jounce_status add_up(const jounce_problem *p, const Fastest *fastest,
                            jounce_motion *motion) {
    double lengths[JOUNCE_MOST_LENGTHS], unit = power_of_two(p->units.time);
    int i, n = jounce_lengths_of(&fastest->families[fastest->turned], &fastest->profile, lengths);
    jounce_clear(motion);
    for (i = 0; i < n; i++) {
        double length = larger(0.0, lengths[i] * unit);
        motion->duration += length;
        motion->count += length > 0.0;
    }
    return is_finite(motion->duration) ? JOUNCE_OK : JOUNCE_RANGE;
}

jounce_status jounce_transfer_times(const jounce_state *start, const jounce_state *end,
                                    const jounce_limits *limits, jounce_motion *motion) {
    Fastest fastest;
    jounce_problem p;
    jounce_pose(start, end, limits, jounce_size_of_positions(start, end), 0.0, &p);
    if (p.status != JOUNCE_OK) {
        return p.status;
    }
    jounce_start_inside(&p);
    if (p.way.count > 0 || !is_ordinary(&p)) {
        return plan_from_inside(&p, end, limits, motion);
    }
    return find_fastest(&p.task, &fastest) ? add_up(&p, &fastest, motion) : JOUNCE_UNREACHABLE;
}

jounce_status jounce_velocity_transfer(const jounce_state *start, const jounce_state *end,
                                       const jounce_limits *limits, jounce_motion *motion) {
    jounce_state goal = *end;
    jounce_change change;
    jounce_problem p;
    goal.x = start->x;
    jounce_pose(start, &goal, limits, magnitude(start->x), 0.0, &p);
    if (p.status != JOUNCE_OK) {
        return p.status;
    }
    jounce_clear(motion);
    p.position = jounce_bring_acceleration_inside(&p.task, p.start, motion);
    change = jounce_change_velocity(&p.task);
    if (jounce_change_leaves_bounds(&p.task, &change)) {
        return JOUNCE_UNREACHABLE;
    }
    jounce_change_pieces(&p.task, &change, p.position, motion);
    motion->inside_after = jounce_time_inside(&p.whole, motion);
    goal.x = scaled(p.position + change.distance, p.units.length) + p.offset;
    return jounce_finish(&p, &goal, limits, motion);
}
