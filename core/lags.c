/* Equal first-order lags in series behind a motion, exact (a jerk filter, Thompson, Section V).
 *
 * Behind a polynomial r lag i settles to the polynomial (1 + s/omega)^-i r, a finite sum over the
 * derivatives of r; what it differs from that by decays as exp(-omega t) times powers of omega t.
 */
#include "task.h"

/* What lag i settles to: the sum over k of C(i + k - 1, k) r^(k) / (-omega)^k. */
static double settled(const double *motion, int order, int i, double omega) {
    double sum = motion[0], weight = 1.0;
    int k;
    for (k = 1; k <= order; k++) {
        weight *= -(double)(i + k - 1) / ((double)k * omega);
        sum += weight * motion[k];
    }
    return sum;
}

void jounce_advance_lags(double *lags, int count, const double *motion, int order, double tau,
                         double omega) {
    double later[JOUNCE_MOST_LAGS], weight = exponential(-omega * tau);
    double weights[JOUNCE_MOST_LAGS], off[JOUNCE_MOST_LAGS];
    int i, j, k;
    for (k = 0; k <= order; k++) {
        later[k] = jounce_taylor(motion, order, k, tau);
    }
    for (i = 0; i < count; i++) {
        off[i] = lags[i] - settled(motion, order, i + 1, omega);
        weights[i] = weight;
        weight *= omega * tau / (double)(i + 1);
    }
    for (i = 0; i < count; i++) {
        double sum = settled(later, order, i + 1, omega);
        for (j = 0; j <= i; j++) {
            sum += weights[j] * off[i - j];
        }
        lags[i] = sum;
    }
}

void jounce_lags_behind(double *lags, int count, const jounce_motion *motion, double duration,
                        double omega) {
    double left = duration;
    int i;
    for (i = 0; count > 0 && i < motion->count && left > 0.0; i++) {
        const jounce_piece *piece = &motion->pieces[i];
        double tau = smaller(piece->duration, left), state[4];
        state[0] = piece->x;
        state[1] = piece->v;
        state[2] = piece->a;
        state[3] = piece->j;
        jounce_advance_lags(lags, count, state, 3, tau, omega);
        left -= tau;
    }
}

void jounce_lags_output(const double *lags, int count, const double *motion, int highest,
                        double omega, double *out) {
    double chain[JOUNCE_MOST_LAGS + 1];
    int i, k;
    chain[0] = motion[0];
    for (i = 0; i < count; i++) {
        chain[i + 1] = lags[i];
    }
    for (k = 0; k <= highest; k++) {
        out[k] = chain[count];
        for (i = count; i > 0; i--) {
            chain[i] = omega * (chain[i - 1] - chain[i]);
        }
        if (k < highest) {
            chain[0] = motion[k + 1];
        }
    }
}
