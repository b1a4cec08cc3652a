/* A motion planned beforehand, as a function of time. */

#include "piecewise.c"

/* Hosts that add up t += h come to a break early by rounding: this part of the last step counts
 * as the break. */
#define BREAK_SLACK 1e-6

static void core_initialize(State *s) {
    (void)s;
}

static void core_outputs(State *s, int running) {
    double early = BREAK_SLACK * s->memory[LAST_STEP];
    (void)running;
    jounce_evaluate_at(&planned, s->time - s->value[V_DELAY], early, ORDER,
                       s->value + V_POSITION);
    s->value[V_POSITION] += s->value[V_OFFSET];
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache, (void)t;
    s->memory[LAST_STEP] = h;
    return NULL;
}
