/* A continuous linear system under inputs held during the step: exact, by matrix exponential.
 *
 * A and B are those of balanced states, x = scale * balanced, all scales powers of two.
 */

#define TERMS 19 /* of the Taylor series for a norm of at most 1/2: the remainder is below 1e-23 */

typedef double Matrix[N_SOME(N_STATES)][N_SOME(N_STATES)];

typedef struct {
    double step; /* for which the rest holds; 0: for none */
    Matrix change, integral; /* exp(A h) - 1, and the integral of exp(A s) from 0 to h */
    double gain[N_SOME(N_STATES)][N_SOME(N_INPUTS)];
    Matrix small, product;
    double x[N_SOME(N_STATES)];
} Cache;

static void core_initialize(State *s) {
    (void)s;
}

static void core_outputs(State *s, int running) {
    const double *x = s->value + V_STATE, *u = s->value + V_INPUT;
    int i, j;
    (void)running;
    for (i = 0; i < N_OUTPUTS; i++) {
        double sum = 0.0;
        for (j = 0; j < N_STATES; j++) {
            sum += output_by_state[i][j] * x[j];
        }
        for (j = 0; j < N_INPUTS; j++) {
            sum += output_by_input[i][j] * u[j];
        }
        s->value[V_OUTPUT + i] = sum;
    }
    for (i = 0; i < N_STATES; i++) {
        double sum = 0.0;
        for (j = 0; j < N_STATES; j++) {
            sum += rate_by_state[i][j] / scale[j] * x[j];
        }
        for (j = 0; j < N_INPUTS; j++) {
            sum += rate_by_input[i][j] * u[j];
        }
        s->value[V_DERIVATIVE + i] = scale[i] * sum;
    }
}

static void multiply(Matrix a, Matrix b, Matrix product) {
    int i, j, k;
    for (i = 0; i < N_STATES; i++) {
        for (j = 0; j < N_STATES; j++) {
            product[i][j] = 0.0;
        }
        for (k = 0; k < N_STATES; k++) {
            for (j = 0; j < N_STATES; j++) {
                product[i][j] += a[i][k] * b[k][j];
            }
        }
    }
}

/* Both by the Taylor series of a fraction of h, then doubled. */
static void exponentiate(Cache *c, double h) {
    double norm = 0.0, step = h;
    int i, j, k, doublings = 0;
    for (j = 0; j < N_STATES; j++) {
        double sum = 0.0;
        for (i = 0; i < N_STATES; i++) {
            sum += magnitude(rate_by_state[i][j]);
        }
        norm = larger(norm, sum);
    }
    while (norm * step > 0.5) {
        step *= 0.5;
        doublings += 1;
    }
    for (i = 0; i < N_STATES; i++) {
        for (j = 0; j < N_STATES; j++) {
            c->small[i][j] = rate_by_state[i][j] * step;
            c->integral[i][j] = i == j;
        }
    }
    for (k = TERMS; k > 1; k--) {
        multiply(c->small, c->integral, c->product);
        for (i = 0; i < N_STATES; i++) {
            for (j = 0; j < N_STATES; j++) {
                c->integral[i][j] = (i == j) + c->product[i][j] / k;
            }
        }
    }
    multiply(c->small, c->integral, c->change);
    for (i = 0; i < N_STATES; i++) {
        for (j = 0; j < N_STATES; j++) {
            c->integral[i][j] *= step;
        }
    }
    for (k = 0; k < doublings; k++) {
        multiply(c->change, c->integral, c->product);
        for (i = 0; i < N_STATES; i++) {
            for (j = 0; j < N_STATES; j++) {
                c->integral[i][j] = 2.0 * c->integral[i][j] + c->product[i][j];
            }
        }
        multiply(c->change, c->change, c->product);
        for (i = 0; i < N_STATES; i++) {
            for (j = 0; j < N_STATES; j++) {
                c->change[i][j] = 2.0 * c->change[i][j] + c->product[i][j];
            }
        }
    }
}

static void prepare(Cache *c, double h) {
    int i, j, k;
    exponentiate(c, h);
    for (i = 0; i < N_STATES; i++) {
        for (k = 0; k < N_INPUTS; k++) {
            double sum = 0.0;
            for (j = 0; j < N_STATES; j++) {
                sum += c->integral[i][j] * rate_by_input[j][k];
            }
            c->gain[i][k] = scale[i] * sum;
        }
        for (j = 0; j < N_STATES; j++) {
            c->change[i][j] = scale[i] * c->change[i][j] / scale[j];
        }
    }
    c->step = h;
}

static const char *core_step(State *s, Cache *c, double t, double h) {
    double *x = s->value + V_STATE, *u = s->value + V_INPUT;
    int i, j;
    /* hosts take h as a difference of times: what is within their rounding is the same step */
    if (c->step == 0.0 || magnitude(h - c->step) > 4.5e-16 * (magnitude(t) + h)) {
        prepare(c, h);
    }
    for (i = 0; i < N_STATES; i++) {
        double sum = 0.0;
        for (j = 0; j < N_STATES; j++) {
            sum += c->change[i][j] * x[j];
        }
        for (j = 0; j < N_INPUTS; j++) {
            sum += c->gain[i][j] * u[j];
        }
        c->x[i] = x[i] + sum;
    }
    for (i = 0; i < N_STATES; i++) {
        x[i] = c->x[i];
    }
    return NULL;
}

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
