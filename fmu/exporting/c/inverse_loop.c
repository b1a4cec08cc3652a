/* A whole digital servo loop with the exact inverse of a damped axis. */

#include "running_loop.c"

#include "inverse.c"

static void commanded(double t, double *command) {
    jounce_evaluate_at(&planned, t, 0.0, OWN_ORDER, command);
    remembered(t, 0.0, command + OWN_ORDER + 1);
}
