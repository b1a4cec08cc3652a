/* A sampled PID with feedforward of the command's acceleration. */

#include "controller.c"
#include "ticks.c"

static void core_initialize(State *s) {
    (void)s;
}

static jounce_pid gains(const State *s) {
    const double *v = s->value;
    jounce_pid pid = {v[V_KP], v[V_KI], v[V_KR], v[V_J_HAT], SAMPLE_TIME};
    return pid;
}

static void control(State *s) {
    double *v = s->value, e = v[V_R] - v[V_Y], e_rate;
    jounce_pid pid = gains(s);
#if defined(MEASURED_RATE)
    e_rate = v[V_R_RATE] - v[V_Y_RATE];
#else
    e_rate = (e - v[V_E_PAST]) / SAMPLE_TIME;
#endif
    v[V_U] = jounce_pid_output(&pid, v[V_E_INTEGRAL], e, e_rate, v[V_R_ACCELERATION]);
}

static void core_outputs(State *s, int running) {
    if (!running) {
        control(s);
    }
}

static const char *core_tick(State *s, Cache *cache) {
    double e = s->value[V_R] - s->value[V_Y];
    jounce_pid pid = gains(s);
    (void)cache;
    control(s);
    s->value[V_E_INTEGRAL] = jounce_pid_integral(&pid, s->value[V_E_INTEGRAL], e);
#if !defined(MEASURED_RATE)
    s->value[V_E_PAST] = e;
#endif
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    return run_ticks(s, cache, t + h, h);
}
