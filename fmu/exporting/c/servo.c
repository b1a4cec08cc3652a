/* A whole servo loop: a planned motion, a jerk filter, a sampled controller and a linear plant.
 *
 * At each sample the controller sees command and plant at that very time; its torque is held until
 * the next, and the plant goes on exactly in between, whatever steps a host takes.
 */

#include "controller.c"
#include "lags.c"
#include "own_system.c"
#include "piecewise.c"
#include "pieces.c"
#include "ticks.c"

#define TWO_PI 6.283185307179586

#define SAME_TIME (1e-8 * SAMPLE_TIME) /* what hosts are off by that add up t += h */

#define N_MOTION (ORDER < 2 ? 3 : ORDER + 1) /* the acceleration at least */

enum { REACHED, LAGS }; /* of the memory: the time that plant and filter have come to; the filter */

static double corner(const State *s) {
#if N_LAGS > 0
    return TWO_PI * s->value[V_CORNER_HZ];
#else
    (void)s;
    return 1.0;
#endif
}

/* The command behind the filter, at the time that has been reached. */
static void command(State *s) {
    double motion[N_MOTION] = {0};
    jounce_evaluate_at(&planned, s->memory[REACHED], SAME_TIME, ORDER, motion);
    jounce_lags_output(s->memory + LAGS, N_LAGS, motion, 2, corner(s), s->value + V_R);
}

static void put_out(State *s) {
    jounce_linear plant = own_system();
    double torque = s->value[V_U] + s->value[V_D];
    command(s);
    jounce_linear_outputs(&plant, s->value + V_STATE, &torque, s->value + V_OUTPUT);
    s->value[V_E] = s->value[V_R] - s->value[V_Y];
}

static void filter_on(State *s, double t, double end) {
    while (N_LAGS > 0 && t < end) {
        double motion[N_MOTION] = {0}, next = end;
        size_t piece = jounce_breaks_up_to(&planned, t);
        if (piece <= planned.count && breaks[piece] < end) {
            next = breaks[piece];
        }
        jounce_evaluate_at(&planned, t, 0.0, ORDER, motion);
        jounce_advance_lags(s->memory + LAGS, N_LAGS, motion, ORDER, next - t, corner(s));
        t = next;
    }
}

/* Plant and filter go on to a time; a sample of just before has come too late to see less. */
static void go_on(State *s, Cache *cache, double to) {
    double from = s->memory[REACHED], h = to - from;
    if (h < -SAME_TIME) {
        return;
    }
    if (h > SAME_TIME) {
        jounce_linear plant = own_system();
        double torque = s->value[V_U] + s->value[V_D];
        jounce_linear_step(&plant, &torque, h, 4.5e-16 * (magnitude(to) + h) + 1e-12 * h,
                           cache->work, s->value + V_STATE);
        filter_on(s, from, to);
    }
    s->memory[REACHED] = to;
}

static jounce_pid gains(const State *s) {
    const double *v = s->value;
    jounce_pid pid = {v[V_KP], v[V_KI], v[V_KR], v[V_J_HAT], SAMPLE_TIME};
    return pid;
}

static void control(State *s) {
    double *v = s->value;
    jounce_pid pid = gains(s);
    put_out(s);
    v[V_U] = jounce_pid_output(&pid, v[V_E_INTEGRAL], v[V_E], v[V_R + 1] - v[V_Y_RATE],
                               v[V_R + 2]);
}

static void core_initialize(State *s) { /* the command has coasted in for ever */
    const double *before = states[0];
    double drift = ORDER > 0 ? before[ORDER > 0] : 0.0;
    int i;
    s->memory[REACHED] = s->start;
    for (i = 0; i < N_LAGS; i++) {
        s->memory[LAGS + i] = before[0] - drift * (i + 1) / corner(s);
    }
    s->value[V_U] = 0.0;
}

static void core_outputs(State *s, int running) {
    if (!running) {
        control(s);
    }
    put_out(s);
}

static const char *core_tick(State *s, Cache *cache) {
    jounce_pid pid = gains(s);
    go_on(s, cache, tick_time(s, s->ticks));
    control(s);
    s->value[V_E_INTEGRAL] = jounce_pid_integral(&pid, s->value[V_E_INTEGRAL], s->value[V_E]);
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    const char *problem = run_ticks(s, cache, t + h, h);
    if (!problem) {
        go_on(s, cache, t + h);
    }
    return problem;
}
