/* Pieces of polynomials of any order at one time.
 *
 * Derivative k on a piece is the sum over j >= k of state[j] tau^(j-k) / (j-k)!, by Horner's rule
 * with the inverse factorials multiplied into the state.
 */
#include "evaluation.h"

static const double INVERSE_FACTORIAL[JOUNCE_MOST_ORDER + 1] = {
    1.0, 1.0, 0.5, 0.16666666666666666, 0.041666666666666664, 0.008333333333333333,
    0.001388888888888889, 0.0001984126984126984, 2.48015873015873e-05, 2.7557319223985893e-06,
    2.755731922398589e-07, 2.505210838544172e-08, 2.08767569878681e-09, 1.6059043836821613e-10,
    1.1470745597729725e-11, 7.647163731819816e-13, 4.779477332387385e-14, 2.8114572543455206e-15,
    1.5619206968586225e-16, 8.22063524662433e-18, 4.110317623312165e-19, 1.9572941063391263e-20,
    8.896791392450574e-22, 3.868170170630684e-23, 1.6117375710961184e-24, 6.446950284384474e-26,
    2.4795962632247976e-27, 9.183689863795546e-29, 3.279889237069838e-30, 1.1309962886447716e-31,
    3.7699876288159054e-33, 1.216125041553518e-34, 3.8003907548547434e-36, 1.151633562077195e-37,
    3.387157535521162e-39, 9.67759295863189e-41, 2.6882202662866363e-42, 7.265460179153071e-44,
    1.911963205040282e-45, 4.902469756513544e-47, 1.2256174391283858e-48
};

void jounce_coefficients(const double *state, int degree, double *c) {
    int j;
    for (j = 0; j <= degree; j++) {
        c[j] = state[j] * INVERSE_FACTORIAL[j];
    }
}

size_t jounce_breaks_up_to(const jounce_pieces *pieces, double time) {
    size_t low = 0, high = pieces->count + 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (pieces->breaks[middle] <= time) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

void jounce_evaluate_at(const jounce_pieces *pieces, double time, double early, int last,
                        double *out) {
    Span at = span(pieces, jounce_breaks_up_to(pieces, time + early));
    const double *state = pieces->states + at.index * ((size_t)pieces->order + 1);
    double c[JOUNCE_MOST_ORDER + 1], tau = smaller(time - at.origin, at.longest);
    int k;
    for (k = 0; k <= last; k++) {
        int degree = pieces->order - k;
        out[k] = 0.0;
        if (degree >= 0) {
            jounce_coefficients(state + k, degree, c);
            out[k] = horner(c, degree, tau);
        }
    }
}
