/* What motions planned beforehand share that are functions of time. */

#include "piecewise.c"

/* Hosts that add up t += h come to a break early by rounding: this part of the last step counts
 * as the break. */
#define BREAK_SLACK 1e-6

static void core_initialize(State *s) {
    (void)s;
}

static double own_time(const State *s) {
    return s->time - s->value[V_DELAY];
}

static double early(const State *s) {
    return BREAK_SLACK * s->memory[LAST_STEP];
}

static void put_motion_out(State *s) {
    jounce_evaluate_at(&planned, own_time(s), early(s), ORDER, s->value + V_POSITION);
    s->value[V_POSITION] += s->value[V_OFFSET];
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache, (void)t;
    s->memory[LAST_STEP] = h;
    return NULL;
}
