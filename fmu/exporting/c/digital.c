/* The whole of a digital controller, as macros, tables and values describe it. */

#include "controller.c"

/* The command, its derivatives, and what an inverse that remembers adds to torque and reference. */
#define N_COMMAND (OWN_ORDER + 1 + N_REMEMBERED)

/* Returns the controller; `fed` (N_COMMAND) becomes its torque per command. */
static jounce_controller own_controller(const State *s, double *fed) {
    const double *v = s->value;
    jounce_controller own = {OWN_LAW,
                             OWN_ANTI_WINDUP,
                             OWN_SECTIONS,
                             N_COMMAND - 1,
                             OWN_DT,
                             OWN_KP,
                             OWN_KI,
                             OWN_KR,
                             OWN_RATE_FILTER,
                             OWN_POSITION_GAIN,
                             OWN_VELOCITY_FEEDFORWARD,
                             OWN_FRICTION,
                             OWN_LIMIT,
                             OWN_TRACKING_TIME,
                             OWN_INTEGRAL_LIMIT,
                             OWN_ENCODER_STEP,
                             filter_sections[0],
                             position_gains,
                             NULL};
    int k;
    for (k = 0; k < N_COMMAND; k++) {
        fed[k] = k <= OWN_ORDER ? v[V_FED + k] : (double)(k == OWN_ORDER + 1);
    }
    own.torque = fed;
    return own;
}
