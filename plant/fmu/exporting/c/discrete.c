/* A discrete linear system, run once per sample time: y = C x + D u, then x = A x + B u. */

#include "ticks.c"

typedef struct {
    int unused;
} Cache;

static void core_initialize(State *s) {
    (void)s;
}

static void weigh(State *s, int first_row, int rows, double *result) {
    const double *x = s->value + V_STATE, *u = s->value + V_INPUT;
    int i, j;
    for (i = 0; i < rows; i++) {
        result[i] = 0.0;
        for (j = 0; j < N_STATES; j++) {
            result[i] += by_state[first_row + i][j] * x[j];
        }
        for (j = 0; j < N_INPUTS; j++) {
            result[i] += by_input[first_row + i][j] * u[j];
        }
    }
}

static void core_outputs(State *s, int running) {
    if (!running) {
        weigh(s, N_STATES, N_OUTPUTS, s->value + V_OUTPUT);
    }
}

static const char *core_tick(State *s) {
    int i;
    weigh(s, N_STATES, N_OUTPUTS, s->value + V_OUTPUT);
    weigh(s, 0, N_STATES, s->memory);
    for (i = 0; i < N_STATES; i++) {
        s->value[V_STATE + i] = s->memory[i];
    }
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache;
    return run_ticks(s, t + h, h);
}
