/* A sampled PID with feedforward of the command's acceleration. */

#include "ticks.c"

typedef struct {
    int unused;
} Cache;

static void core_initialize(State *s) {
    (void)s;
}

static void control(State *s) {
    double *v = s->value, e = v[V_R] - v[V_Y], e_rate;
#if defined(MEASURED_RATE)
    e_rate = v[V_R_RATE] - v[V_Y_RATE];
#else
    e_rate = (e - v[V_E_PAST]) / SAMPLE_TIME;
#endif
    v[V_U] = v[V_KP] * e + v[V_KI] * (v[V_E_INTEGRAL] + SAMPLE_TIME * e) + v[V_KR] * e_rate +
             v[V_J_HAT] * v[V_R_ACCELERATION];
}

static void core_outputs(State *s, int running) {
    if (!running) {
        control(s);
    }
}

static const char *core_tick(State *s) {
    double e = s->value[V_R] - s->value[V_Y];
    control(s);
    s->value[V_E_INTEGRAL] += SAMPLE_TIME * e;
#if !defined(MEASURED_RATE)
    s->value[V_E_PAST] = e;
#endif
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache;
    return run_ticks(s, t + h, h);
}
