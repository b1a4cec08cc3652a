/* Random problems for the planner and the follower, to be run under sanitizers.
 *
 * Usage: driver COUNT [SEED]. Every motion must be finite, continuous, end where it should, and
 * keep its bounds from inside_after on. What fails is printed so that it can be pasted into Python
 * after `from jounce.core import *; from math import inf`, as is what does not end in time.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "jounce.h"

enum { SECONDS = 20, BATCH = 1000, SAMPLES = 40, MANY = 300 };

#define INFINITE (1e300 * 1e300)
#define LARGEST 1.7976931348623157e308
#define TOLERANCE 1e-9
#define ROUNDING 1e-13

typedef struct {
    int order;
    jounce_state start, end;
    jounce_limits limits;
} Problem;

static uint64_t seed;
static char current[1000];

/* --- random numbers ----------------------------------------------------------------------------- */

static uint64_t next(void) { /* xorshift64* */
    seed ^= seed >> 12;
    seed ^= seed << 25;
    seed ^= seed >> 27;
    return seed * UINT64_C(2685821657736338717);
}

static double uniform(double low, double high) {
    return low + (high - low) * ((double)(next() >> 11) / 9007199254740992.0);
}

static int one_in(int n) { return next() % (uint64_t)n == 0; }

static double ten_to(double exponent) {
    double value = 1.0, step = exponent < 0.0 ? 0.1 : 10.0;
    int whole = (int)(exponent < 0.0 ? -exponent : exponent);
    while (whole-- > 0) {
        value *= step;
    }
    return value * uniform(1.0, 10.0);
}

static double magnitude(double x) { return x < 0.0 ? -x : x; }

static double larger(double a, double b) { return a > b ? a : b; }

static double square_root(double x) { /* roughly, from above */
    double root = larger(x, 1.0);
    int i;
    for (i = 0; i < 600 && root * root > 1.1 * x; i++) {
        root = 0.5 * (root + x / root);
    }
    return root;
}

static double smaller(double a, double b) { return a < b ? a : b; }

/* --- problems ------------------------------------------------------------------------------------- */

/* Decades that quantities are spread over, and a value that is often zero or round. */
static double value(double decades) {
    double size = one_in(6) ? 0.0 : one_in(3) ? 1.0 : ten_to(uniform(-decades, decades));
    return one_in(2) ? size : -size;
}

static void bound(double decades, int may_lack, double *low, double *high) {
    double size = one_in(3) ? 1.0 : ten_to(uniform(-decades, decades));
    *high = size;
    *low = one_in(2) ? -size : -size * uniform(0.1, 10.0);
    if (may_lack && one_in(6)) {
        *high = one_in(2) ? INFINITE : LARGEST;
        *low = one_in(2) ? -INFINITE : -LARGEST;
    }
}

static Problem problem(void) {
    static const double SPREADS[] = {0.0, 1.0, 1.0, 3.0, 3.0, 10.0, 60.0};
    double decades = SPREADS[next() % 7];
    Problem p;
    memset(&p, 0, sizeof p);
    p.order = one_in(3) ? 2 : 3;
    bound(decades, 1, &p.limits.v_low, &p.limits.v_high);
    bound(decades, p.order == 3, &p.limits.a_low, &p.limits.a_high);
    if (p.order == 3) {
        bound(decades, 0, &p.limits.j_low, &p.limits.j_high);
    } else {
        p.limits.j_low = -INFINITE;
        p.limits.j_high = INFINITE;
    }
    p.start.x = value(decades);
    p.start.v = value(decades);
    p.end.x = one_in(8) ? p.start.x : value(decades);
    p.end.v = one_in(3) ? 0.0 : value(decades);
    if (p.order == 3) {
        p.start.a = value(decades);
        p.end.a = one_in(2) ? 0.0 : value(decades);
    }
    return p;
}

/* Bring an end inside its bounds, as the planner asks for. */
static double inside(double x, double low, double high) {
    return x < low ? low * 0.5 : x > high ? high * 0.5 : x;
}

static void describe(const char *call, const Problem *p, const char *rest) {
    const jounce_limits *l = &p->limits;
    int at = snprintf(current, sizeof current, "%s((%.17g, %.17g", call, p->start.x, p->start.v);
    char *to = current;
    size_t left = sizeof current;
#define SAY(...) at += snprintf(to + at, left - (size_t)at, __VA_ARGS__)
    if (p->order == 3) {
        SAY(", %.17g), (%.17g, %.17g, %.17g), (%.17g, %.17g, %.17g, %.17g, %.17g, %.17g)%s)",
            p->start.a, p->end.x, p->end.v, p->end.a, l->v_low, l->v_high, l->a_low, l->a_high,
            l->j_low, l->j_high, rest);
    } else {
        SAY("), (%.17g, %.17g), (%.17g, %.17g, %.17g, %.17g)%s)", p->end.x, p->end.v, l->v_low,
            l->v_high, l->a_low, l->a_high, rest);
    }
#undef SAY
}

static int fail(const char *what, double found, double expected) {
    printf("%s\n    # %s: %.17g, expected %.17g\n", current, what, found, expected);
    return 1;
}

static void out_of_time(int signal) {
    static const char text[] = "\n    # does not end\n";
    (void)signal;
    if (write(1, current, strlen(current)) < 0 || write(1, text, sizeof text - 1) < 0) {
        _exit(3);
    }
    _exit(2);
}

/* --- what a motion must be ------------------------------------------------------------------------- */

static int is_finite(const jounce_state *s) {
    return s->x - s->x == 0.0 && s->v - s->v == 0.0 && s->a - s->a == 0.0;
}

static jounce_state at(const jounce_piece *piece, double t) {
    double taylor[4];
    jounce_state state;
    taylor[0] = piece->x;
    taylor[1] = piece->v;
    taylor[2] = piece->a;
    taylor[3] = piece->j;
    state.x = jounce_taylor(taylor, 3, 0, t);
    state.v = jounce_taylor(taylor, 3, 1, t);
    state.a = jounce_taylor(taylor, 3, 2, t);
    return state;
}

typedef struct {
    double x, x_span, v, a;
    double reach, gain; /* how far it goes, and by how much v changes, before speeds are gone */
    double time;        /* that of the whole plan, of which a follower takes a sample */
} Sizes;

/* What rounding is measured by. */
static Sizes sizes(const Problem *problem, const jounce_motion *m) {
    const jounce_limits *l = &problem->limits;
    double low = m->end.x, high = m->end.x, jerk = smaller(l->j_high, -l->j_low);
    Sizes s = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    int i;
    for (i = 0; i < m->count; i++) {
        const jounce_piece *p = &m->pieces[i];
        double a_end = p->a + p->j * p->duration;
        low = p->x < low ? p->x : low;
        high = larger(high, p->x);
        s.x = larger(s.x, magnitude(p->x));
        s.v = larger(s.v, magnitude(p->v) + larger(magnitude(p->a), magnitude(a_end)) *
                                                p->duration);
        s.a = larger(s.a, larger(magnitude(p->a), magnitude(a_end)));
    }
    s.x = larger(s.x, magnitude(m->end.x));
    s.v = larger(s.v, larger(magnitude(m->end.v), magnitude(problem->start.v)));
    s.a = larger(s.a, larger(magnitude(m->end.a), magnitude(problem->start.a)));
    s.x_span = high - low + s.v * m->duration;
    s.time = larger(m->duration, s.v / smaller(l->a_high, -l->a_low));
    s.gain = s.a * s.a / jerk;
    s.reach = (s.v + s.gain) * (s.v / smaller(l->a_high, -l->a_low) + s.a / jerk);
    s.reach += square_root((s.v + s.gain) / jerk) * s.v;
    return s;
}

/* Whether the start keeps its bounds, and can keep them when its acceleration goes to zero. */
static int starts_inside(const Problem *p) {
    const jounce_limits *l = &p->limits;
    double a = p->start.a, settled = p->start.v;
    if (a != 0.0) {
        settled += 0.5 * a * a / (a > 0.0 ? -l->j_low : -l->j_high);
    }
    return l->a_low <= a && a <= l->a_high && l->v_low <= p->start.v &&
           p->start.v <= l->v_high && l->v_low <= settled && settled <= l->v_high;
}

/* Whether a ramp of the acceleration takes so little time that it is taken for a jump. */
static int jumps(const Problem *p, const Sizes *s) {
    double steepest = larger(p->limits.j_high, -p->limits.j_low);
    double most = larger(magnitude(p->start.a), magnitude(p->end.a));
    most = larger(most, p->limits.a_high < LARGEST ? p->limits.a_high : 0.0);
    return p->order == 2 || most / steepest < 1e-14 * s->time;
}

static int check_bound(const char *what, double found, double low, double high, double size) {
    if (found > high + TOLERANCE * high + ROUNDING * size) {
        return fail(what, found, high);
    }
    return found < low + TOLERANCE * low - ROUNDING * size ? fail(what, found, low) : 0;
}

static int check_bounds(const Problem *p, const jounce_motion *m, const Sizes *s) {
    const jounce_limits *l = &p->limits;
    double time = 0.0;
    int i, bad = 0;
    for (i = 0; i < m->count && !bad; i++) {
        const jounce_piece *piece = &m->pieces[i];
        double from = larger(m->inside_after - time, 0.0), turn = -piece->a / piece->j;
        double v_size = s->v + magnitude(piece->a) * piece->duration;
        time += piece->duration;
        if (p->order == 3) {
            bad = check_bound("jerk", piece->j, l->j_low, l->j_high, 0.0);
        }
        if (from >= piece->duration * (1.0 - TOLERANCE)) {
            continue;
        }
        bad = bad || check_bound("acceleration", at(piece, from).a, l->a_low, l->a_high, s->a) ||
              check_bound("acceleration", at(piece, piece->duration).a, l->a_low, l->a_high,
                          s->a) ||
              check_bound("velocity", at(piece, from).v, l->v_low, l->v_high, v_size) ||
              check_bound("velocity", at(piece, piece->duration).v, l->v_low, l->v_high, v_size);
        if (!bad && piece->j != 0.0 && from < turn && turn < piece->duration) {
            bad = check_bound("velocity", at(piece, turn).v, l->v_low, l->v_high, v_size);
        }
    }
    return bad;
}

static int near(const char *what, double found, double expected, double slack) {
    return magnitude(found - expected) <= slack ? 0 : fail(what, found, expected);
}

/* Pieces follow one another, from the start to the end. */
static int check_joints(const Problem *p, const jounce_motion *m, const Sizes *s) {
    jounce_state here = p->start, target = m->end;
    double total = 0.0, x_slack;
    double v_slack = TOLERANCE * s->v + ROUNDING * s->gain, a_slack = TOLERANCE * s->a;
    int i, bad = 0;
    x_slack = TOLERANCE * s->x_span + ROUNDING * (s->x + s->reach);
    for (i = 0; i <= m->count && !bad; i++) {
        jounce_state there = target;
        if (i < m->count) {
            there.x = m->pieces[i].x;
            there.v = m->pieces[i].v;
            there.a = m->pieces[i].a;
            bad = m->pieces[i].duration > 0.0 ? 0 : fail("duration", m->pieces[i].duration, 1.0);
        }
        bad = bad || near("position at a joint", there.x, here.x, x_slack) ||
              near("velocity at a joint", there.v, here.v, v_slack);
        if (!jumps(p, s)) {
            bad = bad || near("acceleration at a joint", there.a, here.a, a_slack);
        }
        if (i < m->count) {
            here = at(&m->pieces[i], m->pieces[i].duration);
            total += m->pieces[i].duration;
        }
    }
    return bad || near("sum of durations", total, m->duration, TOLERANCE * total);
}

static int check(const Problem *p, const jounce_motion *m, int to_position) {
    Sizes s = sizes(p, m);
    int i;
    for (i = 0; i < m->count; i++) {
        jounce_state begin = at(&m->pieces[i], 0.0), finish = at(&m->pieces[i],
                                                                 m->pieces[i].duration);
        if (!is_finite(&begin) || !is_finite(&finish)) {
            return fail("not finite", finish.x, 0.0);
        }
    }
    if (m->count > JOUNCE_MOST_PIECES || !(m->duration - m->duration == 0.0)) {
        return fail("duration", m->duration, 0.0);
    }
    return near("end velocity", m->end.v, p->end.v, TOLERANCE * magnitude(p->end.v)) ||
           (to_position && near("end position", m->end.x, p->end.x,
                                ROUNDING * magnitude(p->end.x))) ||
           check_joints(p, m, &s) || check_bounds(p, m, &s);
}

/* --- the calls ------------------------------------------------------------------------------------- */

/* Times alone are those of the whole plan, to the bit. */
static int check_times(const Problem *p, jounce_status status, const jounce_motion *m) {
    jounce_motion times;
    jounce_status found = jounce_transfer_times(&p->start, &p->end, &p->limits, &times);
    if (found != status) {
        return fail("status of times alone", found, status);
    }
    if (status != JOUNCE_OK) {
        return 0;
    }
    return (times.duration == m->duration ? 0 : fail("times", times.duration, m->duration)) ||
           (times.inside_after == m->inside_after ? 0 : fail("inside", times.inside_after,
                                                             m->inside_after)) ||
           (times.count == m->count ? 0 : fail("number of pieces", times.count, m->count));
}

static int transfers(Problem p) {
    jounce_durations found;
    jounce_motion motion;
    jounce_status status;
    char duration[40];
    int bad = 0;
    p.end.v = inside(p.end.v, p.limits.v_low, p.limits.v_high);
    p.end.a = inside(p.end.a, p.limits.a_low, p.limits.a_high);
    describe("transfer", &p, "");
    status = jounce_transfer(&p.start, &p.end, &p.limits, &motion);
    if (status == JOUNCE_OK) {
        bad = check(&p, &motion, 1);
    }
    bad += check_times(&p, status, &motion);
    describe("velocity_transfer", &p, "");
    if (jounce_velocity_transfer(&p.start, &p.end, &p.limits, &motion) == JOUNCE_OK) {
        bad += check(&p, &motion, 0);
    }
    describe("possible_durations", &p, "");
    if (jounce_possible_durations(&p.start, &p.end, &p.limits, &found) == JOUNCE_OK) {
        jounce_interval some = found.intervals[next() % (uint64_t)found.count];
        double high = some.high - some.high == 0.0 ? some.high : 2.0 * some.low + 1.0;
        double time = uniform(some.low, high);
        if (!(some.low >= 0.0 && some.low <= some.high)) {
            bad += fail("interval", some.low, some.high);
        }
        if (time - time != 0.0) {
            return bad;
        }
        snprintf(duration, sizeof duration, ", %.17g", time);
        describe("transfer_lasting", &p, duration);
        if (jounce_transfer_lasting(&p.start, &p.end, &p.limits, time, &motion) == JOUNCE_OK) {
            bad += check(&p, &motion, 1) || near("duration", motion.duration, time,
                                                 TOLERANCE * time);
        }
    }
    return bad;
}

/* Among many, in one block or two, a move lasts as long as alone, to the bit. */
static int lasts_as_long_among_many(double distance, const jounce_limits *l) {
    double durations[MANY], alone = jounce_move_duration(distance, l);
    size_t last = seed % 100 == 0 ? MANY - 1 : 1;
    jounce_column distances = {NULL, 0};
    jounce_columns bounds = {3, 0, {{NULL, 0}, {NULL, 0}, {NULL, 0}},
                             {{NULL, 0}, {NULL, 0}, {NULL, 0}}};
    distances.values = &distance;
    bounds.even = l->v_low == -l->v_high && l->a_low == -l->a_high && l->j_low == -l->j_high;
    bounds.lower[0].values = &l->v_low;
    bounds.lower[1].values = &l->a_low;
    bounds.lower[2].values = &l->j_low;
    bounds.upper[0].values = &l->v_high;
    bounds.upper[1].values = &l->a_high;
    bounds.upper[2].values = &l->j_high;
    jounce_move_durations(&distances, &bounds, last + 1, durations);
    return memcmp(&durations[last], &alone, sizeof alone) == 0 ||
           !fail("among many", durations[last], alone);
}

static int moves(Problem p) {
    jounce_motion motion;
    p.end.x -= p.start.x;
    memset(&p.start, 0, sizeof p.start);
    p.end.v = p.end.a = 0.0;
    describe("transfer", &p, "");
    if (jounce_move(p.end.x, &p.limits, &motion) != JOUNCE_OK) {
        return 0;
    }
    return check(&p, &motion, 1) || !lasts_as_long_among_many(p.end.x, &p.limits) ||
           near("duration alone", jounce_move_duration(p.end.x, &p.limits), motion.duration,
                TOLERANCE * motion.duration);
}

/* A follower of a command that jumps now and then: each sample is a motion within bounds. */
static int follows(Problem p) {
    jounce_follower follower;
    jounce_motion motion;
    double command = p.end.x, velocity = 0.0;
    char rest[160];
    Sizes s;
    int i;
    p.end.a = 0.0;
    follower.limits = p.limits;
    follower.dt = one_in(2) ? 0.01 : ten_to(uniform(-4.0, 1.0));
    follower.period = one_in(4) ? larger(magnitude(p.end.x), 1.0) : INFINITE;
    for (i = 0; i < SAMPLES; i++) {
        if (one_in(10)) {
            command = p.end.x * uniform(-1.0, 1.0);
            velocity = one_in(2) ? 0.0 : inside(p.end.v, p.limits.v_low, p.limits.v_high);
        }
        snprintf(rest, sizeof rest, ", command=%.17g, velocity=%.17g, dt=%.17g, period=%.17g",
                 command, velocity, follower.dt, follower.period);
        describe("follow", &p, rest);
        if (jounce_follow(&follower, &p.start, command, velocity, &motion) != JOUNCE_OK) {
            return 0;
        }
        if (!is_finite(&motion.end)) {
            return fail("not finite", motion.end.x, 0.0);
        }
        motion.inside_after = 0.0;
        s = sizes(&p, &motion);
        s.x = larger(s.x, magnitude(command));
        s.time += (s.v + magnitude(velocity)) / smaller(p.limits.a_high, -p.limits.a_low);
        s.gain += magnitude(velocity) + smaller(p.limits.a_high, -p.limits.a_low) * follower.dt;
        s.reach += s.gain * follower.dt; /* what is done in no time beside a sample */
        s.a += ROUNDING * larger(p.limits.j_high, -p.limits.j_low) * follower.dt;
        if (starts_inside(&p) && ((follower.period == INFINITE && check_joints(&p, &motion, &s)) ||
                                  check_bounds(&p, &motion, &s))) {
            return 1;
        }
        p.start = motion.end;
    }
    return 0;
}

int main(int count, char **arguments) {
    long problems = count > 1 ? atol(arguments[1]) : 50000, i, bad = 0;
    seed = count > 2 ? strtoull(arguments[2], NULL, 10) : UINT64_C(20260101);
    signal(SIGALRM, out_of_time);
    for (i = 0; i < problems; i++) {
        Problem p = problem();
        if (i % BATCH == 0) {
            alarm(SECONDS);
        }
        bad += transfers(p) + moves(p) + (i % 8 == 0 ? follows(p) : 0);
    }
    printf("%ld problems, %ld failed\n", problems, bad);
    return bad > 0;
}
