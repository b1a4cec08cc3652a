/* The first zero of a polynomial that starts positive: proven by bounds, found to rounding. */
#include "first_fall.h"

enum { DEEPEST = 52 };

/* The coefficients about `middle`, in units of `half`. */
static void move_to(const double *q, int count, double middle, double half, double *c) {
    double power = 1.0;
    int i, k;
    for (k = 0; k < count; k++) {
        c[k] = q[k];
    }
    for (i = 0; i < count - 1; i++) {
        for (k = count - 2; k >= i; k--) {
            c[k] += middle * c[k + 1];
        }
    }
    for (k = 0; k < count; k++) {
        c[k] *= power;
        power *= half;
    }
}

static double at(const double *c, int count, double x) {
    double sum = 0.0;
    int k;
    for (k = count - 1; k >= 0; k--) {
        sum = sum * x + c[k];
    }
    return sum;
}

/* Whether c[from] outweighs what follows, the derivative's if from is 1. */
static int outweighs(const double *c, int count, int from) {
    double rest = 0.0;
    int k;
    for (k = from + 1; k < count; k++) {
        rest += (from == 1 ? (double)k : 1.0) * magnitude(c[k]);
    }
    return magnitude(c[from]) > rest;
}

/* The zero of a function that falls from x = -1 to 1, by bisection and Newton. */
static double zero_of(const double *c, int count) {
    double low = -1.0, high = 1.0, x = 0.0;
    int i, k;
    for (i = 0; i < 100; i++) {
        double value = at(c, count, x), slope = 0.0, next;
        if (value > 0.0) {
            low = x;
        } else {
            high = x;
        }
        for (k = count - 1; k > 0; k--) {
            slope = slope * x + (double)k * c[k];
        }
        next = slope < 0.0 ? x - value / slope : 2.0;
        if (!(next > low && next < high)) {
            next = 0.5 * (low + high);
        }
        if (next == x || magnitude(next - x) < 0.25 * EPSILON) {
            break;
        }
        x = next;
    }
    return x;
}

/* The first zero in (0, end] of a polynomial that is positive just after 0; 2 end for none. Parts
 * are halved until the polynomial is positive there, or falls or rises all along. */
static double first_zero(const double *q, int count, double end) {
    double lefts[DEEPEST + 2], rights[DEEPEST + 2], c[JOUNCE_TERMS];
    int depth = 1;
    lefts[0] = 0.0;
    rights[0] = end;
    while (depth > 0) {
        double left, right, half, middle;
        depth -= 1;
        left = lefts[depth];
        right = rights[depth];
        half = 0.5 * (right - left);
        middle = left + half;
        move_to(q, count, middle, half, c);
        if (c[0] > 0.0 && outweighs(c, count, 0)) {
            continue;
        }
        if (outweighs(c, count, 1) || depth == DEEPEST || half < EPSILON * end) {
            if (at(c, count, 1.0) < 0.0) {
                return at(c, count, -1.0) > 0.0 ? middle + half * zero_of(c, count) : left;
            }
            continue;
        }
        rights[depth] = right;
        lefts[depth] = middle;
        rights[depth + 1] = middle;
        lefts[depth + 1] = left;
        depth += 2;
    }
    return 2.0 * end;
}

double jounce_first_fall(const double *q, const double *rounding, double end) {
    int first = 0;
    while (first < JOUNCE_TERMS && magnitude(q[first]) <= rounding[first]) {
        first += 1;
    }
    if (first == JOUNCE_TERMS) {
        return 2.0 * end;
    }
    if (q[first] < 0.0) {
        return 0.0;
    }
    return first_zero(q + first, JOUNCE_TERMS - first, end);
}
