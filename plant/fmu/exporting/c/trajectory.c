/* A motion planned beforehand: a piecewise polynomial in Taylor form, evaluated at any time. */

/* Hosts that add up t += h come to a break early by rounding: this part of the last step counts
 * as the break. */
#define BREAK_SLACK 1e-6

static void core_initialize(State *s) {
    (void)s;
}

static int piece_at(double t) { /* how many breaks are at or before t */
    int low = 0, high = N_BREAKS;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (breaks[middle] <= t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

static void core_outputs(State *s, int running) {
    double t = s->time - s->value[V_DELAY], tau, sum;
    int piece = piece_at(t + BREAK_SLACK * s->memory[LAST_STEP]), k, j;
    const double *row = states[piece];
    (void)running;
    tau = smaller(t - breaks[piece > 0 ? piece - 1 : 0], longest[piece]);
    for (k = 0; k <= ORDER; k++) {
        sum = row[ORDER] * inverse_factorials[ORDER - k];
        for (j = ORDER - 1; j >= k; j--) {
            sum = sum * tau + row[j] * inverse_factorials[j - k];
        }
        s->value[V_POSITION + k] = sum;
    }
    s->value[V_POSITION] += s->value[V_OFFSET];
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)cache, (void)t;
    s->memory[LAST_STEP] = h;
    return NULL;
}
