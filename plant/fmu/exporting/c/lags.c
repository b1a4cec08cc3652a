/* Equal first-order lags in series behind a motion of constant acceleration, exact.
 *
 * Behind a polynomial r lag i settles to the polynomial (1 + s/omega)^-i r; what it differs from
 * that by decays as exp(-omega t) times powers of omega t.
 */

static double settled(const double motion[3], int i, double omega) {
    return motion[0] - i * (motion[1] / omega) +
           0.5 * i * (i + 1) * (motion[2] / omega / omega);
}

static void advance_lags(double *lags, const double motion[3], double tau, double omega) {
    double later[3], weight[N_LAGS], off[N_LAGS];
    int i, j;
    later[0] = motion[0] + tau * (motion[1] + 0.5 * tau * motion[2]);
    later[1] = motion[1] + tau * motion[2];
    later[2] = motion[2];
    weight[0] = exponential(-omega * tau);
    for (i = 0; i < N_LAGS; i++) {
        off[i] = lags[i] - settled(motion, i + 1, omega);
        if (i > 0) {
            weight[i] = weight[i - 1] * omega * tau / i;
        }
    }
    for (i = 0; i < N_LAGS; i++) {
        double sum = settled(later, i + 1, omega);
        for (j = 0; j <= i; j++) {
            sum += weight[j] * off[i - j];
        }
        lags[i] = sum;
    }
}
