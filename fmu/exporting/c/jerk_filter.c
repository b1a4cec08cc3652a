/* Equal first-order lags in series, behind a command of constant acceleration during the step. */

#include "pieces.c"
#include "lags.c"

#define TWO_PI 6.283185307179586

static void core_initialize(State *s) { /* after it has coasted in for ever */
    double omega = TWO_PI * s->value[V_CORNER_HZ];
    int i;
    for (i = 0; i < N_LAGS; i++) {
        s->value[V_LAG + i] =
            s->value[V_START_POSITION] - s->value[V_START_VELOCITY] * (i + 1) / omega;
    }
}

/* Weight of lag i (0: the command) in derivative k of the output. */
static double output_weight(double omega, int k, int i) {
    double weight = 1.0;
    int j, from_end = N_LAGS - i;
    if (from_end > k) {
        return 0.0;
    }
    for (j = 0; j < from_end; j++) { /* binomial, signs alternating from the last lag on */
        weight *= -(double)(k - j) / (j + 1);
    }
    weight = k % 2 ? -weight : weight;
    for (j = 0; j < k; j++) {
        weight *= omega;
    }
    return weight;
}

static void core_outputs(State *s, int running) {
    double omega = TWO_PI * s->value[V_CORNER_HZ], sum;
    int i, k;
    (void)running;
    for (k = 0; k < N_OUTPUTS; k++) {
        sum = 0.0;
        for (i = N_LAGS - k; i <= N_LAGS; i++) {
            sum += output_weight(omega, k, i) *
                   (i > 0 ? s->value[V_LAG + i - 1] : s->value[V_COMMAND]);
        }
        s->value[V_POSITION + k] = sum;
    }
    for (i = 0; i < N_LAGS; i++) {
        double before = i > 0 ? s->value[V_LAG + i - 1] : s->value[V_COMMAND];
        s->value[V_DER_LAG + i] = omega * (before - s->value[V_LAG + i]);
    }
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache, (void)t;
    jounce_advance_lags(s->value + V_LAG, N_LAGS, s->value + V_COMMAND, 2, h,
                        TWO_PI * s->value[V_CORNER_HZ]);
    return NULL;
}

#if defined(HAS_PARTIALS)
static double core_partial(const State *s, int unknown, int known) {
    double omega = TWO_PI * s->value[V_CORNER_HZ];
    int lag = known == V_COMMAND ? 0 : known - V_LAG + 1; /* 0: the command itself */
    if (known != V_COMMAND && !(lag >= 1 && lag <= N_LAGS)) {
        return 0.0;
    }
    if (unknown >= V_DER_LAG && unknown < V_DER_LAG + N_LAGS) {
        int i = unknown - V_DER_LAG + 1;
        return lag == i ? -omega : lag == i - 1 ? omega : 0.0;
    }
    return output_weight(omega, unknown - V_POSITION, lag);
}
#endif
