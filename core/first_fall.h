/* Zeros of the polynomials that guards are between events. */
#ifndef JOUNCE_FIRST_FALL_H
#define JOUNCE_FIRST_FALL_H

#include "jounce.h"
#include "numeric.h"

/* Where the sum of q[k] x^k, k < JOUNCE_TERMS, falls below 0 first, 0 <= x <= end; 2 end where it
 * does not. Coefficients at the beginning that are no larger than their rounding count as 0: the
 * sign just after x = 0 is that of the first other one. */
double jounce_first_fall(const double *q, const double *rounding, double end);

#endif
