/* A whole digital servo loop: planned motion, controller with its delay, axis with friction. */

#include "running_loop.c"

static void commanded(double t, double *command) {
    jounce_evaluate_at(&planned, t, 0.0, OWN_ORDER, command);
}
