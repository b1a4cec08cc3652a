/* Piecewise linear systems between events: states by prepared matrices, events by Taylor series.
 *
 * Along z' = A z a guard g(t) = row exp(A t) z is a power series in t whose coefficients are rows
 * times z. Its first Chebyshev coefficients and a bound of the others prove of most steps that it
 * has no zero there; where they do not, the series is taken as the polynomial that it is.
 */
#include "first_fall.h"

enum { KEPT = 6, CHECKS = KEPT + 1, AT_ONCE = 24 };

#define AT_ONCE_LENGTH 1e-15 /* of a step: shorter ones are none */

/* Where things are in the work space: of each mode the matrices of two steps, column by column; of
 * each guard for both steps the rows of its first Chebyshev coefficients, column by column, and of
 * a bound of the others, then the rows of its Taylor coefficients. */
typedef struct {
    int n, moving, guards, each;
    double *modes, *series, *power, *room;
} Places;

static Places places_of(const jounce_run *run) {
    const jounce_automaton *a = run->automaton;
    Places p;
    p.n = a->states;
    p.moving = a->moving;
    p.guards = a->guards;
    p.each = 2 * p.moving * p.n + p.guards * p.n * (2 * CHECKS + JOUNCE_TERMS);
    p.modes = run->work;
    p.series = p.modes + a->modes * p.each;
    p.power = p.series + (JOUNCE_TERMS + 2) * p.n;
    p.room = p.power + p.moving * p.n;
    return p;
}

static double *matrix_of(const Places *p, int mode, int step) {
    return p->modes + mode * p->each + step * p->moving * p->n;
}

static double *checks_of(const Places *p, int mode, int step, int guard) {
    return p->modes + mode * p->each + 2 * p->moving * p->n +
           (guard * 2 + step) * CHECKS * p->n;
}

static double *terms_of(const Places *p, int mode, int guard) {
    return p->modes + mode * p->each + 2 * p->moving * p->n + p->guards * 2 * CHECKS * p->n +
           guard * JOUNCE_TERMS * p->n;
}

static double dot(const double *a, const double *b, int n) {
    double sum = 0.0;
    int i;
    for (i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* product (rows x n) = by A, of whose rows only the moving ones are not 0. */
static void times_rates(const double *by, const double *rates, int rows, const Places *p,
                        double factor, double *product) {
    int i, j, k;
    for (i = 0; i < rows; i++) {
        for (j = 0; j < p->n; j++) {
            double sum = 0.0;
            for (k = 0; k < p->moving; k++) {
                sum += by[i * p->n + k] * rates[k * p->n + j];
            }
            product[i * p->n + j] = sum * factor;
        }
    }
}

/* The moving rows of exp(A h), column by column. */
static void make_matrix(const Places *p, const double *rates, double h, double *matrix) {
    int i, j, k, size = p->moving * p->n;
    for (i = 0; i < size; i++) {
        matrix[i] = i % p->moving == i / p->moving;
        p->power[i] = i % p->n == i / p->n;
    }
    for (k = 1; k < JOUNCE_TERMS + 4; k++) {
        times_rates(p->power, rates, p->moving, p, h / (double)k, p->room);
        for (i = 0; i < p->moving; i++) {
            for (j = 0; j < p->n; j++) {
                p->power[i * p->n + j] = p->room[i * p->n + j];
                matrix[j * p->moving + i] += p->room[i * p->n + j];
            }
        }
    }
}

/* The rows of a guard's Taylor coefficients, in units of the longer step. */
static void expand(const Places *p, const double *rates, const double *row, double h,
                   double *terms) {
    int i, k;
    for (i = 0; i < p->n; i++) {
        terms[i] = row[i];
    }
    for (k = 1; k < JOUNCE_TERMS; k++) {
        times_rates(terms + (k - 1) * p->n, rates, 1, p, h / (double)k, terms + k * p->n);
    }
}

/* The rows of the first Chebyshev coefficients on [0, ratio], and of a bound of the others:
 * x^k on [0, 1] is the sum over j of 2^(1-2k) C(2k, k-j) T_j(2x - 1), half of it at j = 0. */
static void make_checks(const Places *p, const double *terms, double ratio, double *checks) {
    double *row = p->series;
    int i, j, k;
    for (i = 0; i < p->n; i++) {
        checks[KEPT * p->n + i] = 0.0;
    }
    for (j = 0; j < JOUNCE_TERMS; j++) {
        double size = 1.0; /* of ratio^k 2^(1-2k) C(2k, k-j), at k = j first */
        for (i = 0; i < p->n; i++) {
            row[i] = 0.0;
        }
        for (k = 0; k < j; k++) {
            size *= 0.25 * ratio;
        }
        size *= j > 0 ? 2.0 : 1.0;
        for (k = j; k < JOUNCE_TERMS; k++) {
            for (i = 0; i < p->n; i++) {
                row[i] += size * terms[k * p->n + i];
            }
            size *= 0.25 * ratio * (double)((2 * k + 2) * (2 * k + 1)) /
                    (double)((k + 1 - j) * (k + 1 + j));
        }
        for (i = 0; i < p->n; i++) {
            if (j < KEPT) {
                checks[i * KEPT + j] = row[i];
            } else {
                checks[KEPT * p->n + i] += magnitude(row[i]);
            }
        }
    }
}

void jounce_prepare(jounce_run *run) {
    const jounce_automaton *a = run->automaton;
    Places p = places_of(run);
    int mode, guard, step;
    for (mode = 0; mode < a->modes; mode++) {
        const double *rates = a->rates + mode * p.moving * p.n;
        for (guard = 0; guard < p.guards; guard++) {
            expand(&p, rates, a->rows + (mode * p.guards + guard) * p.n, run->steps[0],
                   terms_of(&p, mode, guard));
        }
        for (step = 0; step < 2; step++) {
            make_matrix(&p, rates, run->steps[step], matrix_of(&p, mode, step));
            for (guard = 0; guard < p.guards; guard++) {
                make_checks(&p, terms_of(&p, mode, guard), run->steps[step] / run->steps[0],
                            checks_of(&p, mode, step, guard));
            }
        }
    }
    run->at_once = 0;
}

/* Whether a guard's row z is proven to stay positive during a whole step. */
static int stays(const double *checks, const double *z, int n) {
    const double *bound = checks + KEPT * n;
    double c[KEPT] = {0.0}, rest = 0.0;
    int i, j;
    for (i = 0; i < n; i++) {
        rest += bound[i] * magnitude(z[i]);
        for (j = 0; j < KEPT; j++) {
            c[j] += checks[i * KEPT + j] * z[i];
        }
    }
    for (j = 1; j < KEPT; j++) {
        rest += magnitude(c[j]);
    }
    return c[0] > rest;
}

static int none_falls(const jounce_run *run, const Places *p, int step) {
    const double *next = run->automaton->next + run->mode * p->guards;
    int guard;
    for (guard = 0; guard < p->guards; guard++) {
        if (next[guard] >= 0.0 &&
            !stays(checks_of(p, run->mode, step, guard), run->z, p->n)) {
            return 0;
        }
    }
    return 1;
}

/* Where a guard falls first within `end` longer steps; 2 end where it does not. */
static double fall_of(const double *terms, const double *z, int n, double end) {
    double q[JOUNCE_TERMS], rounding[JOUNCE_TERMS];
    int i, k;
    for (k = 0; k < JOUNCE_TERMS; k++) {
        double sum = 0.0, size = 0.0;
        for (i = 0; i < n; i++) {
            sum += terms[k * n + i] * z[i];
            size += magnitude(terms[k * n + i] * z[i]);
        }
        q[k] = sum;
        rounding[k] = ROUNDING * size;
    }
    return jounce_first_fall(q, rounding, end);
}

static double first_of(const jounce_run *run, const Places *p, double end, int *first) {
    const double *next = run->automaton->next + run->mode * p->guards;
    double soonest = 2.0 * end;
    int guard;
    *first = -1;
    for (guard = 0; guard < p->guards; guard++) {
        double fall = next[guard] < 0.0 ? 2.0 * end
                                        : fall_of(terms_of(p, run->mode, guard), run->z, p->n, end);
        if (fall <= end && (*first < 0 || fall < soonest)) {
            soonest = fall;
            *first = guard;
        }
    }
    return soonest;
}

static void move_whole(const jounce_run *run, const Places *p, int step) {
    const double *matrix = matrix_of(p, run->mode, step);
    double *after = p->series;
    int i, j;
    for (i = 0; i < p->moving; i++) {
        after[i] = 0.0;
    }
    for (j = 0; j < p->n; j++) {
        for (i = 0; i < p->moving; i++) {
            after[i] += matrix[j * p->moving + i] * run->z[j];
        }
    }
    for (i = 0; i < p->moving; i++) {
        run->z[i] = after[i];
    }
}

/* Go on by h, at most the longer step, by the Taylor series. */
static void move_part(const jounce_run *run, const Places *p, double h) {
    const double *rates = run->automaton->rates + run->mode * p->moving * p->n;
    double *term = p->series, *after = p->series + p->n;
    int i, k;
    for (i = 0; i < p->n; i++) {
        term[i] = run->z[i];
        after[i] = 0.0;
    }
    for (k = 1; k < JOUNCE_TERMS + 4; k++) {
        for (i = 0; i < p->moving; i++) {
            after[i] = dot(rates + i * p->n, term, p->n) * (h / (double)k);
        }
        for (i = 0; i < p->n; i++) {
            term[i] = i < p->moving ? after[i] : 0.0;
            run->z[i] += term[i];
        }
    }
}

static void pass(jounce_run *run, int guard) {
    const jounce_automaton *a = run->automaton;
    int i, n = a->states, which = run->mode * a->guards + guard, projects = 0;
    double along = dot(a->along + which * n, run->z, n);
    for (i = 0; i < n; i++) {
        projects = projects || a->onto[which * n + i] != 0.0;
        run->z[i] += a->onto[which * n + i] * along;
    }
    run->mode = (int)a->next[which];
    run->holding = projects ? run->mode : run->holding;
}

jounce_status jounce_record(jounce_run *run, double t) {
    int i, n = run->automaton->states;
    double *row;
    if (run->segments == NULL) {
        return JOUNCE_OK;
    }
    if (run->count == run->room) {
        return JOUNCE_FULL;
    }
    row = run->segments + run->count * (size_t)(n + 2);
    row[0] = t;
    row[1] = (double)run->mode;
    for (i = 0; i < n; i++) {
        row[2 + i] = run->z[i];
    }
    run->count += 1;
    return JOUNCE_OK;
}

/* Where modes change for ever at one instant, the one that holds something (a motor that sticks)
 * holds it to the end of the step: what would end it is there by rounding alone. */
static int on_edge(jounce_run *run) {
    if (run->at_once <= AT_ONCE || run->holding < 0) {
        return 0;
    }
    run->mode = run->holding;
    return 1;
}

/* A step or what there is until a guard falls; returns how long it was. */
static double advance_once(jounce_run *run, const Places *p, double h, int step) {
    double fall;
    int guard;
    if (step >= 0 && none_falls(run, p, step)) {
        move_whole(run, p, step);
        return h;
    }
    fall = first_of(run, p, h / run->steps[0], &guard);
    if (guard < 0) {
        if (step >= 0) {
            move_whole(run, p, step);
        } else {
            move_part(run, p, h);
        }
        return h;
    }
    h = smaller(fall * run->steps[0], h);
    if (fall > 0.0) {
        move_part(run, p, h);
    }
    pass(run, guard);
    return fall > 0.0 ? h : 0.0;
}

/* The step that goes into a span a whole number of times, else the longer one. */
static int step_for(const jounce_run *run, double span) {
    double ratio = span / run->steps[0];
    double whole = ratio < 1e9 ? (double)(int64_t)(ratio + 0.5) : ratio;
    return magnitude(ratio - whole) > 1e-6;
}

jounce_status jounce_advance(jounce_run *run, double t, double span) {
    Places p = places_of(run);
    double done = 0.0, slack = 1e-9 * run->steps[1];
    int step = step_for(run, span);
    double length = run->steps[step];
    run->at_once = 0;
    run->holding = -1;
    while (span - done > slack) {
        int whole = span - done >= length * (1.0 - 1e-9);
        double went, h = whole ? length : smaller(span - done, run->steps[0]);
        int held = on_edge(run);
        if (jounce_record(run, t + done) != JOUNCE_OK) {
            return JOUNCE_FULL;
        }
        if (held) {
            move_part(run, &p, h);
            went = h;
        } else {
            went = advance_once(run, &p, h, whole ? step : -1);
        }
        done += went;
        if (went > AT_ONCE_LENGTH * run->steps[0]) {
            run->at_once = 0;
            run->holding = -1;
            continue;
        }
        run->count -= run->segments != NULL;
        run->at_once += 1;
        if (run->at_once > AT_ONCE && run->holding < 0) {
            return JOUNCE_CHATTER;
        }
    }
    return JOUNCE_OK;
}
