/* A digital controller, run once a sample on what is commanded and measured. */

#include "digital.c"
#include "ticks.c"

static void core_initialize(State *s) {
    (void)s;
}

/* One sample; `memory` is the controller's, and e, the torque asked for and u come out. */
static void control(const State *s, double *memory, double *out) {
    const double *v = s->value;
    double fed[N_COMMAND];
    jounce_controller own = own_controller(s, fed);
    jounce_controller_sample(&own, memory, v[V_Y], v[V_MOVED], v + V_R, v + V_AHEAD, out);
}

static void core_outputs(State *s, int running) {
    double memory[JOUNCE_CONTROLLER_STATE(OWN_SECTIONS)];
    int i;
    if (!running) {
        for (i = 0; i < JOUNCE_CONTROLLER_STATE(OWN_SECTIONS); i++) {
            memory[i] = s->value[V_OWN + i];
        }
        control(s, memory, s->value + V_E);
    }
}

static const char *core_tick(State *s, Cache *cache) {
    (void)cache;
    control(s, s->value + V_OWN, s->value + V_E);
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    return run_ticks(s, cache, t + h, h);
}
