/* Balancing: units of the states, powers of two, in which rows and columns of a matrix match. */
#include "jounce.h"
#include "numeric.h"

/* By how much the sum of both norms must shrink for a change to be worth it. */
#define WORTH_IT 0.95

/* The Euclidean norm of n numbers, `stride` apart. */
static double length_of(const double *x, int n, int stride) {
    double sum = 0.0;
    int i;
    for (i = 0; i < n; i++) {
        sum += x[i * stride] * x[i * stride];
    }
    return square_root(sum);
}

/* The power of two that brings a column's norm to that of its row. */
static double factor_for(double column, double row) {
    double f = 1.0;
    while (column < 0.5 * row) {
        f *= 2.0;
        column *= 2.0;
        row *= 0.5;
    }
    while (0.5 * column >= row) {
        f *= 0.5;
        column *= 0.5;
        row *= 2.0;
    }
    return f;
}

static int match(double *a, double *scale, int n, int i) {
    double column = length_of(a + i, n, n), row = length_of(a + i * n, n, 1), f;
    int j;
    if (!(column > 0.0 && row > 0.0 && column + row < INFINITE)) {
        return 0;
    }
    f = factor_for(column, row);
    if (f == 1.0 || column * f + row / f >= WORTH_IT * (column + row)) {
        return 0;
    }
    scale[i] *= f;
    for (j = 0; j < n; j++) {
        a[i * n + j] /= f;
    }
    for (j = 0; j < n; j++) {
        a[j * n + i] *= f;
    }
    return 1;
}

void jounce_balance(double *a, double *scale, int n) {
    int i, changed = 1;
    for (i = 0; i < n; i++) {
        scale[i] = 1.0;
    }
    while (changed) {
        changed = 0;
        for (i = 0; i < n; i++) {
            changed += match(a, scale, n, i);
        }
    }
}
