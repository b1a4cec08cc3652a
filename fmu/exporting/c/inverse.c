/* What the exact inverse of a damped axis remembers of the planned motion.
 *
 * On a piece its state is what the command's derivatives settle to, and a part that decays from the
 * piece's start on; before the motion it is 0.
 */

#include "linear.c"

/* What is added to torque and reference, `out`, at a time; as near before a break counts as it. */
static void remembered(double time, double early, double *out) {
    jounce_linear decay = {N_INVERSE, 0, 0, inverse_rates[0], NULL, NULL, NULL, inverse_scale};
    double command[ORDER + 1], state[N_INVERSE], work[JOUNCE_LINEAR_WORK(N_INVERSE, 0)] = {0};
    const double *fed = command + ORDER + 1 - N_INVERSE_FED;
    size_t begun = jounce_breaks_up_to(&planned, time + early);
    int i, k;
    out[0] = out[1] = 0.0;
    if (begun == 0) {
        return;
    }
    jounce_evaluate_at(&planned, time, early, ORDER, command);
    for (i = 0; i < N_INVERSE; i++) {
        state[i] = inverse_decaying[begun - 1][i];
    }
    jounce_linear_step(&decay, NULL, larger(time - breaks[begun - 1], 0.0), 0.0, work, state);
    for (i = 0; i < N_INVERSE; i++) {
        for (k = 0; k < N_INVERSE_FED; k++) {
            state[i] += inverse_settled[i][k] * fed[k];
        }
        out[0] += inverse_shown[0][i] * state[i];
        out[1] += inverse_shown[1][i] * state[i];
    }
    out[0] += inverse_through[0] * fed[0];
    out[1] += inverse_through[1] * fed[0];
}
