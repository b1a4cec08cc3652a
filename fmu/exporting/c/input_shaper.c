/* An input shaper over a sampled command: weighted parts of it, delayed by whole samples. */

#include "ticks.c"

/* The ring of the last samples is the memory; that of sample k is at k modulo its length. */

static void core_initialize(State *s) {
    (void)s;
}

static void core_outputs(State *s, int running) {
    if (!running) {
        s->value[V_SHAPED] = s->value[V_COMMAND];
    }
}

static const char *core_tick(State *s, Cache *cache) {
    int64_t now = s->ticks % N_RING;
    double sum = 0.0;
    int i;
    (void)cache;
    for (i = 0; s->ticks == 0 && i < N_RING; i++) { /* it has stood still before */
        s->memory[i] = s->value[V_COMMAND];
    }
    s->memory[now] = s->value[V_COMMAND];
    for (i = 0; i < N_PARTS; i++) {
        sum += part_weight[i] * s->memory[(now + N_RING - (int64_t)part_delay[i]) % N_RING];
    }
    s->value[V_SHAPED] = sum;
    return NULL;
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    return run_ticks(s, cache, t + h, h);
}
