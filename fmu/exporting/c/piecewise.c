/* A motion planned beforehand: a piecewise polynomial in Taylor form, evaluated at any time. */

static int piece_at(double t) { /* how many breaks are at or before t */
    int low = 0, high = N_BREAKS;
    while (low < high) {
        int middle = low + (high - low) / 2;
        if (breaks[middle] <= t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* Position and derivatives 1 ... ORDER; a time before a break by at most `early` counts as it. */
static void motion_at(double t, double early, double *motion) {
    int piece = piece_at(t + early), k, j;
    const double *row = states[piece];
    double tau = smaller(t - breaks[piece > 0 ? piece - 1 : 0], longest[piece]);
    for (k = 0; k <= ORDER; k++) {
        double sum = row[ORDER] * inverse_factorials[ORDER - k];
        for (j = ORDER - 1; j >= k; j--) {
            sum = sum * tau + row[j] * inverse_factorials[j - k];
        }
        motion[k] = sum;
    }
}
