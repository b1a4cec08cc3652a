/* A continuous linear system under inputs held during the step. */

#include "own_system.c"

static void core_initialize(State *s) {
    (void)s;
}

static void core_outputs(State *s, int running) {
    const double *x = s->value + V_STATE, *u = s->value + V_INPUT;
    jounce_linear system = own_system();
    (void)running;
    jounce_linear_outputs(&system, x, u, s->value + V_OUTPUT);
    jounce_linear_rates(&system, x, u, s->value + V_DERIVATIVE);
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    jounce_linear system = own_system();
    /* hosts take h as a difference of times: what is within their rounding is the same step */
    double slack = 4.5e-16 * (magnitude(t) + h);
    jounce_linear_step(&system, s->value + V_INPUT, h, slack, cache->work, s->value + V_STATE);
    return NULL;
}

#if defined(HAS_PARTIALS)
static double core_partial(const State *s, int unknown, int known) {
    int by_state = known >= V_STATE && known < V_STATE + N_STATES;
    int j = known - (by_state ? V_STATE : V_INPUT);
    (void)s;
    if (unknown >= V_DERIVATIVE && unknown < V_DERIVATIVE + N_STATES) {
        int i = unknown - V_DERIVATIVE;
        return scale[i] * (by_state ? rate_by_state[i][j] / scale[j] : rate_by_input[i][j]);
    }
    return by_state ? output_by_state[unknown - V_OUTPUT][j]
                    : output_by_input[unknown - V_OUTPUT][j];
}
#endif
