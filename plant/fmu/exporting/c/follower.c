/* Following commands in minimum time within bounds on velocity and acceleration, replanned at
 * every sample and exact inside it.
 */

#include "ticks.c"

#define TWO_PI 6.283185307179586
#define RESOLUTION 8.881784197001252e-16 /* of a command's position: what is nearer is there */
#define ROUNDING 3.552713678800501e-15

typedef struct {
    int unused;
} Cache;

/* What is kept from one sample to the next: the state when it begins, its command, its bounds. */
enum { X, V, A, COMMAND, SPEED, V_LOW, V_HIGH, UP, DOWN, OMEGA, FINISHED, LAGS };

typedef struct {
    double duration, motion[3]; /* position, velocity and acceleration when it begins */
} Piece;

typedef struct {
    Piece pieces[4];
    int count;
    double motion[3]; /* at the end */
} Motion;

static void add_piece(Motion *m, double duration, double x, double v, double a) {
    Piece piece = {duration, {x, v, a}};
    if (duration > 0.0 && m->count < 4) {
        m->pieces[m->count++] = piece;
    }
}

static void end_motion(Motion *m, double x, double v, double a) {
    m->motion[0] = x;
    m->motion[1] = v;
    m->motion[2] = a;
}

/* Slow down to rest at the command, which is at r and moves at u when the sample begins. */
static void add_stop(Motion *m, double begun, double top, double down, double r, double u,
                     double dt) {
    double stopping = larger(top, 0.0) / down, left = dt - begun;
    add_piece(m, smaller(stopping, left), r + u * begun - 0.5 * top * top / down, u + top, -down);
    add_piece(m, left - stopping, r + u * (begun + stopping), u, 0.0);
}

/* To the velocity bound, from either side of it; then cruise, slow down and stop. */
static void by_the_bound(Motion *m, double x, double v, double r, double u, double top, double up,
                         double down, double dt) {
    double e = x - r, w = v - u, gone = 0.0, left = dt, stop, cruise, change;
    if (w != top) {
        double t;
        change = w < top ? up : -down;
        t = (top - w) / change;
        if (t >= left) {
            add_piece(m, dt, x, v, change);
            end_motion(m, x + (w + 0.5 * change * left) * left + u * dt, u + (w + change * left),
                       change);
            return;
        }
        add_piece(m, t, x, v, change);
        gone = 0.5 * (w + top) * t;
        left -= t;
    }
    stop = -0.5 * top * top / down;
    if (e + gone + top * left <= stop) {
        add_piece(m, left, x + gone + u * (dt - left), u + top, 0.0);
        end_motion(m, x + (gone + top * left) + u * dt, u + top, 0.0);
        return;
    }
    cruise = top > 0.0 ? (stop - e - gone) / top : 0.0;
    add_piece(m, cruise, x + gone + u * (dt - left), u + top, 0.0);
    add_stop(m, dt - left + larger(cruise, 0.0), top, down, r, u, dt);
    w = top > 0.0 ? top - down * (left - cruise) : 0.0;
    if (w > 0.0) {
        end_motion(m, x + (-0.5 * w * w / down - e) + u * dt, u + w, -down);
    } else {
        end_motion(m, x + -e + u * dt, u, 0.0);
    }
}

/* The first dt of the fastest motion to a command ahead (or that is being overshot less). */
static void rise_to(Motion *m, double x, double v, double r, double u, double beyond, double slack,
                    double v_max, double up, double down, double dt) {
    double e = x - r, w = v - u, rise = 0.0, later = w + up * dt, peak;
    if (beyond < -slack) {
        rise = -beyond * (2.0 * up * down / (up + down));
    }
    if (w > 0.0) {
        rise += w * w;
    }
    if (later + u <= v_max && (later <= 0.0 || later * later <= rise)) {
        add_piece(m, dt, x, v, up);
        end_motion(m, x + ((w + later) * (0.5 * dt) + u * dt), later + u, up);
        return;
    }
    if (v == v_max && e + w * (dt + w * (0.5 / down)) <= 0.0) {
        add_piece(m, dt, x, v, 0.0);
        end_motion(m, x + v * dt, v, 0.0);
        return;
    }
    peak = square_root(rise);
    if (peak < v_max - u) {
        double t = smaller(larger((peak - w) / up, 0.0), dt);
        add_piece(m, t, x, v, up);
        add_stop(m, t, peak, down, r, u, dt);
        w = peak - down * (dt - (peak - w) / up);
        if (w > 0.0) {
            end_motion(m, r + u * dt + -w * w * (0.5 / down), u + w, -down);
        } else {
            end_motion(m, r + u * dt + 0.0, u + 0.0, 0.0);
        }
        return;
    }
    by_the_bound(m, x, v, r, u, v_max - u, up, down, dt);
}

/* The motion during the first dt of a sample that begins with the memory given. */
static void follow(const double *memory, double dt, Motion *m) {
    double x = memory[X], v = memory[V], u = memory[SPEED], r = memory[COMMAND];
    double up = memory[UP], down = memory[DOWN], slack = RESOLUTION * magnitude(r), w, beyond;
    int i;
#if defined(PERIOD)
    r = x - nearest_remainder(x - r, PERIOD);
#endif
    w = v - u;
    beyond = w > 0.0 ? x - r + w * w * (0.5 / down) : x - r - w * w * (0.5 / up);
    m->count = 0;
    if (beyond < -slack || (w > 0.0 && beyond <= slack)) {
        rise_to(m, x, v, r, u, beyond, slack, memory[V_HIGH], up, down, dt);
    } else if (beyond > slack || w < 0.0) {
        rise_to(m, -x, -v, -r, -u, -beyond, slack, -memory[V_LOW], down, up, dt);
        for (i = 0; i < 3; i++) {
            int k;
            m->motion[i] = -m->motion[i];
            for (k = 0; k < m->count; k++) {
                m->pieces[k].motion[i] = -m->pieces[k].motion[i];
            }
        }
    } else {
        add_piece(m, dt, r, u, 0.0);
        end_motion(m, r + u * dt, u, 0.0);
    }
}

/* Cut off an excess over the bounds that is mere rounding. */
static double inside(double value, double low, double high) {
    if (high < value && value <= high + ROUNDING * magnitude(high)) {
        return high;
    }
    if (low > value && value >= low - ROUNDING * magnitude(low)) {
        return low;
    }
    return value;
}

#if N_LAGS > 0
#include "lags.c"

static void lag_behind(const Motion *m, double dt, double omega, double *lags) {
    double left = dt;
    int i;
    for (i = 0; i < m->count && left > 0.0; i++) {
        double tau = smaller(m->pieces[i].duration, left);
        advance_lags(lags, m->pieces[i].motion, tau, omega);
        left -= tau;
    }
}

static void put_out(State *s, const double motion[3], const double *lags) {
    double chain[N_LAGS + 1], omega = s->memory[OMEGA];
    int i, k;
    chain[0] = motion[0];
    for (i = 0; i < N_LAGS; i++) {
        chain[i + 1] = lags[i];
    }
    for (k = 0; k < 3; k++) {
        s->value[V_POSITION + k] = chain[N_LAGS];
        for (i = N_LAGS; i > 0; i--) {
            chain[i] = omega * (chain[i - 1] - chain[i]);
        }
        chain[0] = k == 0 ? inside(motion[1], s->memory[V_LOW], s->memory[V_HIGH]) : motion[2];
    }
}
#else
static void lag_behind(const Motion *m, double dt, double omega, double *lags) {
    (void)m, (void)dt, (void)omega, (void)lags;
}

static void put_out(State *s, const double motion[3], const double *lags) {
    (void)lags;
    s->value[V_POSITION] = motion[0];
    s->value[V_VELOCITY] = inside(motion[1], s->memory[V_LOW], s->memory[V_HIGH]);
    s->value[V_ACCELERATION] = motion[2];
}
#endif

static void take_bounds(State *s) {
    s->memory[V_LOW] = s->value[V_VELOCITY_MIN];
    s->memory[V_HIGH] = s->value[V_VELOCITY_MAX];
    s->memory[UP] = s->value[V_ACCELERATION_MAX];
    s->memory[DOWN] = -s->value[V_ACCELERATION_MIN];
#if N_LAGS > 0
    s->memory[OMEGA] = TWO_PI * s->value[V_CORNER_HZ];
#endif
}

static void core_initialize(State *s) {
    int i;
    s->memory[X] = s->value[V_START_POSITION];
    s->memory[V] = s->value[V_START_VELOCITY];
    s->memory[A] = 0.0;
    s->memory[FINISHED] = 1.0;
    take_bounds(s);
    for (i = 0; i < N_LAGS; i++) {
        s->memory[LAGS + i] = s->value[V_START_POSITION];
    }
}

static void core_outputs(State *s, int running) {
    if (!running) {
        put_out(s, s->memory, s->memory + LAGS);
    }
}

static void finish_sample(State *s) {
    Motion motion;
    int i;
    follow(s->memory, SAMPLE_TIME, &motion);
    lag_behind(&motion, SAMPLE_TIME, s->memory[OMEGA], s->memory + LAGS);
    for (i = 0; i < 3; i++) {
        s->memory[X + i] = motion.motion[i];
    }
    s->memory[FINISHED] = 1.0;
}

static void core_tick(State *s) {
    double command = s->value[V_COMMAND];
    if (s->memory[FINISHED] == 0.0) {
        finish_sample(s);
    }
    take_bounds(s);
#if defined(PERIOD)
    command = truncated_remainder(command, PERIOD);
#endif
    s->memory[COMMAND] = command;
    s->memory[SPEED] =
        smaller(larger(s->value[V_COMMAND_VELOCITY], s->memory[V_LOW]), s->memory[V_HIGH]);
    s->memory[FINISHED] = 0.0;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    double since, lags[N_SOME(N_LAGS)];
    const char *problem = run_ticks(s, t + h, h);
    Motion motion;
    int i;
    (void)cache;
    if (problem) {
        return problem;
    }
    since = t + h - tick_time(s, s->ticks - 1);
    if (s->memory[FINISHED] == 0.0 && since >= SAMPLE_TIME - tick_slack(h)) {
        finish_sample(s);
    }
    if (s->memory[FINISHED] != 0.0) {
        put_out(s, s->memory, s->memory + LAGS);
        return NULL;
    }
    for (i = 0; i < N_LAGS; i++) {
        lags[i] = s->memory[LAGS + i];
    }
    follow(s->memory, since, &motion);
    lag_behind(&motion, since, s->memory[OMEGA], lags);
    put_out(s, motion.motion, lags);
    return NULL;
}
