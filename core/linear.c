/* Linear systems under inputs that are held during each step: exact, by matrix exponential. */
#include "jounce.h"
#include "numeric.h"

/* Of the Taylor series for a norm of at most 1/2: the remainder is below 1e-23. */
enum { TERMS = 19 };

/* The parts of the work space: exp(A h) - 1, the integral of exp(A s) from 0 to h, that times B,
 * and room. */
typedef struct {
    double *step, *change, *integral, *gain, *fraction, *product, *next;
} Parts;

static Parts parts_of(const jounce_linear *system, double *work) {
    size_t n = (size_t)system->states, square = n * n;
    Parts parts;
    parts.step = work;
    parts.change = work + 1;
    parts.integral = parts.change + square;
    parts.gain = parts.integral + square;
    parts.fraction = parts.gain + n * (size_t)system->inputs;
    parts.product = parts.fraction + square;
    parts.next = parts.product + square;
    return parts;
}

void jounce_weigh(const double *by_state, const double *by_input, int rows,
                  const jounce_linear *sizes, const double *x, const double *u, double *result) {
    int i, j, n = sizes->states, m = sizes->inputs;
    for (i = 0; i < rows; i++) {
        double sum = 0.0;
        for (j = 0; j < n; j++) {
            sum += by_state[i * n + j] * x[j];
        }
        for (j = 0; j < m; j++) {
            sum += by_input[i * m + j] * u[j];
        }
        result[i] = sum;
    }
}

void jounce_linear_outputs(const jounce_linear *system, const double *x, const double *u,
                           double *y) {
    jounce_weigh(system->c, system->d, system->outputs, system, x, u, y);
}

void jounce_linear_rates(const jounce_linear *system, const double *x, const double *u,
                         double *rates) {
    int i, j, n = system->states, m = system->inputs;
    for (i = 0; i < n; i++) {
        double sum = 0.0;
        for (j = 0; j < n; j++) {
            sum += system->a[i * n + j] / system->scale[j] * x[j];
        }
        for (j = 0; j < m; j++) {
            sum += system->b[i * m + j] * u[j];
        }
        rates[i] = system->scale[i] * sum;
    }
}

/* The product of two n by n matrices. */
static void multiply(const double *a, const double *b, int n, double *product) {
    int i, j, k;
    for (i = 0; i < n; i++) {
        for (j = 0; j < n; j++) {
            product[i * n + j] = 0.0;
        }
        for (k = 0; k < n; k++) {
            for (j = 0; j < n; j++) {
                product[i * n + j] += a[i * n + k] * b[k * n + j];
            }
        }
    }
}

/* The largest sum of magnitudes of a column. */
static double norm_of(const double *a, int n) {
    double norm = 0.0;
    int i, j;
    for (j = 0; j < n; j++) {
        double sum = 0.0;
        for (i = 0; i < n; i++) {
            sum += magnitude(a[i * n + j]);
        }
        norm = larger(norm, sum);
    }
    return norm;
}

/* matrix = 2 matrix + factor matrix: from exp(A h) - 1 or its integral to those of 2 h. */
static void double_step(const Parts *p, double *matrix, int n) {
    int i;
    multiply(p->change, matrix, n, p->product);
    for (i = 0; i < n * n; i++) {
        matrix[i] = 2.0 * matrix[i] + p->product[i];
    }
}

/* Both by the Taylor series of a fraction of h, then doubled. */
static void exponentiate(const jounce_linear *system, const Parts *p, double h) {
    double norm = norm_of(system->a, system->states), step = h;
    int i, k, n = system->states, doublings = 0;
    while (norm * step > 0.5) {
        step *= 0.5;
        doublings += 1;
    }
    for (i = 0; i < n * n; i++) {
        p->fraction[i] = system->a[i] * step;
        p->integral[i] = i % (n + 1) == 0;
    }
    for (k = TERMS; k > 1; k--) {
        multiply(p->fraction, p->integral, n, p->product);
        for (i = 0; i < n * n; i++) {
            p->integral[i] = (i % (n + 1) == 0) + p->product[i] / (double)k;
        }
    }
    multiply(p->fraction, p->integral, n, p->change);
    for (i = 0; i < n * n; i++) {
        p->integral[i] *= step;
    }
    for (k = 0; k < doublings; k++) {
        double_step(p, p->integral, n);
        double_step(p, p->change, n);
    }
}

static void prepare(const jounce_linear *system, const Parts *p, double h) {
    int i, j, k, n = system->states, m = system->inputs;
    exponentiate(system, p, h);
    for (i = 0; i < n; i++) {
        for (k = 0; k < m; k++) {
            double sum = 0.0;
            for (j = 0; j < n; j++) {
                sum += p->integral[i * n + j] * system->b[j * m + k];
            }
            p->gain[i * m + k] = system->scale[i] * sum;
        }
        for (j = 0; j < n; j++) {
            p->change[i * n + j] = system->scale[i] * p->change[i * n + j] / system->scale[j];
        }
    }
    *p->step = h;
}

void jounce_linear_step(const jounce_linear *system, const double *u, double h, double slack,
                        double *work, double *x) {
    Parts p = parts_of(system, work);
    int i, n = system->states;
    if (*p.step == 0.0 || magnitude(h - *p.step) > slack) {
        prepare(system, &p, h);
    }
    jounce_weigh(p.change, p.gain, n, system, x, u, p.next);
    for (i = 0; i < n; i++) {
        x[i] += p.next[i];
    }
}
