/* A discrete linear system, run once per sample time: y = C x + D u, then x = A x + B u. */

#include "linear.c"
#include "ticks.c"

static void core_initialize(State *s) {
    (void)s;
}

/* Rows of A and B, or of C and D below them. */
static void weigh(State *s, int first_row, int rows, double *result) {
    jounce_linear sizes = {N_STATES, N_INPUTS, N_OUTPUTS, NULL, NULL, NULL, NULL, NULL};
    jounce_weigh(row_by_state[first_row], row_by_input[first_row], rows, &sizes, s->value + V_STATE,
                 s->value + V_INPUT, result);
}

static void core_outputs(State *s, int running) {
    if (!running) {
        weigh(s, N_STATES, N_OUTPUTS, s->value + V_OUTPUT);
    }
}

static const char *core_tick(State *s, Cache *cache) {
    int i;
    (void)cache;
    weigh(s, N_STATES, N_OUTPUTS, s->value + V_OUTPUT);
    weigh(s, 0, N_STATES, s->memory);
    for (i = 0; i < N_STATES; i++) {
        s->value[V_STATE + i] = s->memory[i];
    }
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    return run_ticks(s, cache, t + h, h);
}
