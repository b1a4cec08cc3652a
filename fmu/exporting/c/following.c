/* Following commands in minimum time within bounds on velocity, acceleration and jerk, replanned
 * at every sample and exact inside it.
 */

#include "core.c"
#include "ticks.c"

#define TWO_PI 6.283185307179586

#define LARGEST 1.7976931348623157e308 /* a bound that is none */

/* What is kept from one sample to the next: the state when it begins, its command, its bounds. */
enum { X, V, A, J, COMMAND, SPEED, LIMITS, OMEGA = LIMITS + 6, FINISHED, LAGS };

/* A bound, where it is one: that of the highest derivative always is. */
static double bound(const State *s, int i) {
    double kept = s->memory[LIMITS + i];
    int none = magnitude(kept) >= LARGEST && i / 2 + 1 != ORDER;
    return none ? (kept > 0.0 ? INFINITE : -INFINITE) : kept;
}

static jounce_follower follower_of(const State *s, double dt) {
    jounce_follower follower = {
        {bound(s, 0), bound(s, 1), bound(s, 2), bound(s, 3), bound(s, 4), bound(s, 5)}, dt, PERIOD};
    return follower;
}

static void take_bounds(State *s) {
    int i;
    for (i = 0; i < 6; i++) {
        s->memory[LIMITS + i] = i < 2 * ORDER ? s->value[V_VELOCITY_MIN + i]
                                : i % 2       ? LARGEST
                                              : -LARGEST;
    }
#if N_LAGS > 0
    s->memory[OMEGA] = TWO_PI * s->value[V_CORNER_HZ];
#endif
}

/* Go on by a time within a sample: motion (4) and lags are those at its end. */
static const char *follow(const State *s, double time, double *motion, double *lags) {
    jounce_follower follower = follower_of(s, time);
    jounce_state state = {s->memory[X], s->memory[V], s->memory[A]};
    jounce_motion way;
    if (jounce_follow(&follower, &state, s->memory[COMMAND], s->memory[SPEED], &way)) {
        return "the motion leaves the range of a double: use other units";
    }
    motion[0] = way.end.x;
    motion[1] = way.end.v;
    motion[2] = way.end.a;
    motion[3] = way.count > 0 ? way.pieces[way.count - 1].j : 0.0;
    jounce_lags_behind(lags, N_LAGS, &way, time, s->memory[OMEGA]);
    return NULL;
}

static void put_out(State *s, const double *motion, const double *lags) {
    jounce_lags_output(lags, N_LAGS, motion, ORDER, s->memory[OMEGA], s->value + V_POSITION);
}

static void core_initialize(State *s) {
    int i;
    s->memory[X] = s->value[V_START_POSITION];
    s->memory[V] = s->value[V_START_VELOCITY];
    s->memory[A] = s->memory[J] = 0.0;
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

static const char *finish_sample(State *s) {
    double motion[4];
    const char *problem = follow(s, SAMPLE_TIME, motion, s->memory + LAGS);
    int i;
    for (i = 0; i < 4 && !problem; i++) {
        s->memory[X + i] = motion[i];
    }
    s->memory[FINISHED] = 1.0;
    return problem;
}

static const char *core_tick(State *s, Cache *cache) {
    (void)cache;
    if (s->memory[FINISHED] == 0.0) {
        const char *problem = finish_sample(s);
        if (problem) {
            return problem;
        }
    }
    take_bounds(s);
    s->memory[COMMAND] = s->value[V_COMMAND];
    s->memory[SPEED] = s->value[V_COMMAND_VELOCITY];
    s->memory[FINISHED] = 0.0;
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    double since, motion[4], lags[N_SOME(N_LAGS)];
    const char *problem = run_ticks(s, cache, t + h, h);
    int i;
    if (problem) {
        return problem;
    }
    since = t + h - tick_time(s, s->ticks - 1);
    if (s->memory[FINISHED] == 0.0 && since >= SAMPLE_TIME - tick_slack(h)) {
        problem = finish_sample(s);
    }
    if (s->memory[FINISHED] != 0.0) {
        put_out(s, s->memory, s->memory + LAGS);
        return problem;
    }
    for (i = 0; i < N_LAGS; i++) {
        lags[i] = s->memory[LAGS + i];
    }
    problem = follow(s, since, motion, lags);
    if (!problem) {
        put_out(s, motion, lags);
    }
    return problem;
}
