/* What evaluation at one time and at many share: the span of a piece, and Horner's rule. */
#ifndef JOUNCE_EVALUATION_H
#define JOUNCE_EVALUATION_H

#include "jounce.h"
#include "numeric.h"

#define LARGEST 1.7976931348623157e308

/* One piece of those before, between and after the breaks: its times are low <= t < high. */
typedef struct {
    size_t index;
    double low, high, origin, longest;
} Span;

static inline Span span(const jounce_pieces *p, size_t index) {
    Span s;
    int outside = index == 0 || index > p->count;
    s.index = index;
    s.low = index == 0 ? -LARGEST : p->breaks[index - 1];
    s.high = index > p->count ? INFINITE : p->breaks[index];
    s.origin = p->breaks[index == 0 ? 0 : index - 1];
    s.longest = outside ? INFINITE : p->durations[index - 1];
    return s;
}

/* Of a polynomial of some degree in Taylor form: c[j] = state[j] / j!. */
void jounce_coefficients(const double *state, int degree, double *c);

static inline double horner(const double *c, int degree, double tau) {
    double sum = c[degree];
    int j;
    for (j = degree - 1; j >= 0; j--) {
        sum = sum * tau + c[j];
    }
    return sum;
}

#endif
