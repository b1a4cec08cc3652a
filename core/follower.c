/* Followers: each sample is the start of a minimum-time motion to the command, of which it takes
 * the first part.
 *
 * Seen from the command, which moves at its own constant velocity u, the motion is one from
 * (e, w, a) to rest at zero with velocity bounds shifted by u (Thompson, Section II). A sample
 * depends on nothing but the state when it begins, so that a run is the same steps one by one.
 */
#include "task.h"

#define THERE 8.881784197001252e-16 /* 2^-50 of a command's position: what is nearer is there */
#define NOTHING_YET 7.888609052210118e-31 /* 2^-100 of what a sample is worth counts as zero */

/* What is seen from the command, and where it ends after the sample. */
typedef struct {
    double e, w, a; /* when the sample begins */
    double u, dt;
    double v_low, v_high; /* of w */
    double up, down;
} Seen;

/* The end is either seen from the command, or as a distance from where the sample began. */
typedef struct {
    int from_command;
    double offset, w, a;
} Reached;

static void add_seen(jounce_motion *m, double duration, double e, double w, double a) {
    jounce_add(m, duration, e, w, a, 0.0);
}

static Reached moved(double offset, double w, double a) {
    Reached r = {0, offset, w, a};
    return r;
}

static Reached at_command(double offset, double w, double a) {
    Reached r = {1, offset, w, a};
    return r;
}

/* Slow down to rest at the command, having reached velocity `top` a time `begun` after the
 * sample's begin. */
static void add_stop(jounce_motion *m, double begun, double top, double down, double dt) {
    double stopping = larger(top, 0.0) / down, left = dt - begun;
    add_seen(m, smaller(stopping, left), -0.5 * top * top / down, top, -down);
    add_seen(m, left - stopping, 0.0, 0.0, 0.0);
}

/* To the velocity bound, from either side of it; then cruise, slow down and stop. */
static Reached by_the_bound(jounce_motion *m, const Seen *s, double top) {
    double e = s->e, w = s->w, gone = 0.0, left = s->dt, stop, cruise;
    if (w != top) {
        double change = w < top ? s->up : -s->down, t = (top - w) / change;
        if (t >= left) {
            add_seen(m, left, e, w, change);
            return moved((w + 0.5 * change * left) * left, w + change * left, change);
        }
        add_seen(m, t, e, w, change);
        gone = 0.5 * (w + top) * t;
        left -= t;
    }
    stop = -0.5 * top * top / s->down;
    if (e + gone + top * left <= stop) {
        add_seen(m, left, e + gone, top, 0.0);
        return moved(gone + top * left, top, 0.0);
    }
    cruise = top > 0.0 ? larger((stop - e - gone) / top, 0.0) : 0.0; /* or it goes beyond */
    add_seen(m, cruise, e + gone, top, 0.0);
    add_stop(m, s->dt - left + cruise, top, s->down, s->dt);
    w = top > 0.0 ? top - s->down * (left - cruise) : 0.0;
    return w > 0.0 ? moved(-0.5 * w * w / s->down - e, w, -s->down) : at_command(0.0, 0.0, 0.0);
}

/* The first dt of the fastest motion to a command ahead (or that is being overshot less). */
static Reached rise_to(jounce_motion *m, const Seen *s, double beyond, double slack) {
    double e = s->e, w = s->w, up = s->up, down = s->down, dt = s->dt, top = s->v_high;
    double rise = beyond < -slack ? -beyond * (2.0 / (1.0 / up + 1.0 / down)) : 0.0;
    double later = w + up * dt, peak;
    if (w > 0.0) {
        rise += w * w;
    }
    if (later <= top && (later <= 0.0 || later * later <= rise)) {
        add_seen(m, dt, e, w, up);
        return moved((w + later) * (0.5 * dt), later, up);
    }
    if (w == top && e + w * (dt + w * (0.5 / down)) <= 0.0) {
        add_seen(m, dt, e, w, 0.0);
        return moved(w * dt, w, 0.0);
    }
    peak = square_root(rise);
    if (peak < top) {
        double t = smaller(larger((peak - w) / up, 0.0), dt);
        add_seen(m, t, e, w, up);
        add_stop(m, t, peak, down, dt);
        w = peak - down * (dt - (peak - w) / up);
        return w > 0.0 ? at_command(-w * w * (0.5 / down), w, -down) : at_command(0.0, 0.0, 0.0);
    }
    return by_the_bound(m, s, top);
}

/* The sample with bounded acceleration. */
static Reached sample_by_speed(const Seen *s, double slack, jounce_motion *m) {
    double w = s->w;
    double beyond = w > 0.0 ? s->e + w * w * (0.5 / s->down) : s->e - w * w * (0.5 / s->up);
    if (beyond < -slack || (w > 0.0 && beyond <= slack)) {
        return rise_to(m, s, beyond, slack);
    }
    if (beyond > slack || w < 0.0) {
        Seen o = {-s->e, -s->w, -s->a, -s->u, s->dt, -s->v_high, -s->v_low, s->down, s->up};
        Reached r = rise_to(m, &o, -beyond, slack);
        jounce_turn(m, 0);
        r.offset = -r.offset;
        r.w = -r.w;
        r.a = -r.a;
        return r;
    }
    add_seen(m, s->dt, 0.0, 0.0, 0.0);
    return at_command(0.0, 0.0, 0.0);
}

/* Powers of two that bring time to the length of a sample, and distance to what matters in it. */
static jounce_units units_of(const Seen *s) {
    jounce_units units;
    int power = exponent_of(smaller(s->up, s->down)), length;
    units.time = exponent_of(s->dt);
    length = power + 2 * units.time;
    if (s->e != 0.0 && exponent_of(s->e) > length) {
        length = exponent_of(s->e);
    }
    if (s->w != 0.0 && exponent_of(s->w) + units.time > length) {
        length = exponent_of(s->w) + units.time;
    }
    units.length = length;
    return units;
}

static double bound_in_units(double bound, int exponent) {
    return is_finite(bound) ? clamp(scaled(bound, exponent), -1e36, 1e36) : bound;
}

/* Whether products of a few such numbers are far from the ends of the range. */
static int is_mid(double x) { return x == 0.0 || (magnitude(x) > 1e-15 && magnitude(x) < 1e15); }

static int is_moderate(const Seen *s) {
    return is_mid(s->e) && is_mid(s->w) && is_mid(s->up) && is_mid(s->down) &&
           is_mid(s->dt);
}

/* The sample with bounded acceleration, in units in which no square leaves the range. */
static Reached sample_in_own_units(const Seen *seen, double slack, jounce_motion *m) {
    jounce_units units = units_of(seen);
    int t = -units.time, x = -units.length, v = x - t, a = v - t, i;
    Seen s = *seen;
    Reached reached;
    s.e = scaled(s.e, x);
    s.w = scaled(s.w, v);
    s.dt = scaled(s.dt, t);
    s.v_low = scaled(s.v_low, v);
    s.v_high = scaled(s.v_high, v);
    s.up = bound_in_units(s.up, a);
    s.down = bound_in_units(s.down, a);
    reached = sample_by_speed(&s, scaled(slack, x), m);
    reached.offset = scaled(reached.offset, -x);
    reached.w = scaled(reached.w, -v);
    reached.a = scaled(reached.a, -a);
    for (i = 0; i < m->count; i++) {
        jounce_piece *piece = &m->pieces[i];
        piece->duration = scaled(piece->duration, -t);
        piece->x = scaled(piece->x, -x);
        piece->v = scaled(piece->v, -v);
        piece->a = scaled(piece->a, -a);
    }
    return reached;
}

/* --- bounded jerk ------------------------------------------------------------------------------- */

static double zero_if_nothing(double value, double least) {
    return magnitude(value) > least ? value : 0.0;
}

/* Cut a motion off after a time. */
static void cut(jounce_motion *m, double dt) {
    double left = dt;
    int i;
    for (i = 0; i < m->count; i++) {
        if (m->pieces[i].duration >= left) {
            m->pieces[i].duration = left;
            m->count = i + 1;
            return;
        }
        left -= m->pieces[i].duration;
    }
    if (left > 0.0) { /* rest where the motion ended */
        jounce_add(m, left, m->end.x, m->end.v, 0.0, 0.0);
    }
}

/* The sample with bounded jerk: of a plan to rest at the command, or to its velocity where that
 * is as fast as the bounds allow and the command is not caught up. */
static jounce_status sample_by_jerk(const Seen *s, const jounce_limits *seen_limits, double position,
                             jounce_motion *m) {
    double gentle = smaller(s->up, s->down); /* a sample is worth no more than the bounds allow */
    double least = smaller(smaller(seen_limits->j_high, -seen_limits->j_low) * s->dt, gentle) *
                   NOTHING_YET;
    jounce_state start, end = {0.0, 0.0, 0.0};
    jounce_status status;
    if (!is_finite(least)) {
        least = 0.0;
    }
    start.x = zero_if_nothing(s->e, least * s->dt * s->dt);
    start.v = zero_if_nothing(s->w, least * s->dt);
    start.a = zero_if_nothing(s->a, least);
    status = jounce_approach(&start, &end, seen_limits, magnitude(s->e) + magnitude(position), m);
    if (status != JOUNCE_OK) {
        status = jounce_velocity_transfer(&start, &end, seen_limits, m);
    }
    if (status == JOUNCE_OK) {
        cut(m, s->dt);
    }
    return status;
}

/* A position as seen from a command that is no farther than matters within a sample: from beyond
 * some times the distance in which one could stop in the end, the motion until then is the same;
 * and the position keeps its digits beside a command of 1e300. */
static double nearer(const Seen *s, const jounce_limits *limits) {
    double power = larger(s->up, s->down), gentle = smaller(s->up, s->down), time = s->dt;
    double rise = limits->j_high, fall = -limits->j_low, jerk = smaller(rise, fall), turn = 0.0;
    double speed = magnitude(s->w) + power * time, far;
    if (is_finite(jerk)) {
        double push = smaller(magnitude(s->a) + larger(rise, fall) * time,
                              larger(magnitude(s->a), power));
        speed = magnitude(s->w) + push * (time + 0.5 * push / jerk);
        speed = smaller(speed, larger(magnitude(s->w) + 0.5 * s->a * s->a / jerk,
                                      larger(s->v_high, -s->v_low)));
        turn = push / jerk + 2.0 * square_root(speed / jerk);
    }
    far = 4.0 * speed * (time + turn + speed / gentle);
    return magnitude(s->e) > far ? clamp(s->e, -far, far) : s->e;
}

/* --- a sample ------------------------------------------------------------------------------------ */

/* Turn pieces seen from the command into positions; `base` is where that is, u its velocity. */
static void place(jounce_motion *m, double base, double u) {
    double time = 0.0;
    int i;
    for (i = 0; i < m->count; i++) {
        m->pieces[i].x += base + u * time;
        m->pieces[i].v += u;
        time += m->pieces[i].duration;
    }
    m->duration = time;
}

/* The state at the end of a motion, seen from the command. */
static Reached run_out(const jounce_motion *m) {
    const jounce_piece *last = &m->pieces[m->count - 1];
    double state[4], t = last->duration;
    Reached r;
    state[0] = last->x;
    state[1] = last->v;
    state[2] = last->a;
    state[3] = last->j;
    r.from_command = 1;
    r.offset = jounce_taylor(state, 3, 0, t);
    r.w = jounce_taylor(state, 3, 1, t);
    r.a = jounce_taylor(state, 3, 2, t);
    return r;
}

jounce_status jounce_follow(const jounce_follower *f, const jounce_state *state, double command,
                            double command_velocity, jounce_motion *m) {
    jounce_limits seen_limits = f->limits;
    double u = clamp(command_velocity, f->limits.v_low, f->limits.v_high);
    double slack = THERE * magnitude(command), off, base;
    int jerky = is_finite(f->limits.j_high), wraps = is_finite(f->period);
    Reached r;
    Seen s;
    off = state->x - command;
    if (wraps) {
        command = truncated_remainder(command, f->period);
        off = nearest_remainder(state->x - command, f->period);
        slack = THERE * magnitude(command);
    }
    seen_limits.v_low -= u;
    seen_limits.v_high -= u;
    s.e = off;
    s.w = state->v - u;
    s.a = jerky ? state->a : 0.0;
    s.u = u;
    s.dt = f->dt;
    s.v_low = seen_limits.v_low;
    s.v_high = seen_limits.v_high;
    s.up = f->limits.a_high;
    s.down = -f->limits.a_low;
    s.e = nearer(&s, &f->limits);
    slack = s.e == off ? slack : 0.0; /* no rounding of a command that is far off */
    m->count = 0;
    m->duration = m->inside_after = 0.0;
    if (jerky) {
        jounce_status status = sample_by_jerk(&s, &seen_limits, state->x, m);
        if (status != JOUNCE_OK) {
            return status;
        }
        r = run_out(m);
    } else {
        r = is_moderate(&s) ? sample_by_speed(&s, slack, m) : sample_in_own_units(&s, slack, m);
    }
    base = wraps || s.e != off ? state->x - s.e : command;
    if (jerky && base != command) { /* as if the command were no farther than matters */
        r.from_command = 0;
        r.offset -= s.e;
    }
    place(m, base, u);
    m->end.x = (r.from_command ? base : state->x) + (r.offset + u * f->dt);
    m->end.v = r.w == s.w ? state->v : u + r.w;
    m->end.v = r.w == s.v_high ? f->limits.v_high : r.w == s.v_low ? f->limits.v_low : m->end.v;
    m->end.v = jounce_inside(m->end.v, f->limits.v_low, f->limits.v_high);
    m->end.a = r.a;
    return is_finite(m->end.x) && is_finite(m->end.v) ? JOUNCE_OK : JOUNCE_RANGE;
}
