/* The whole of a digital controller, as macros, tables and values describe it. */

#include "controller.c"

#define N_COMMAND (OWN_ORDER + 1) /* the command and its derivatives */

static jounce_controller own_controller(const State *s) {
    const double *v = s->value;
    jounce_controller own = {OWN_LAW,
                             OWN_ANTI_WINDUP,
                             OWN_SECTIONS,
                             OWN_ORDER,
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
    own.torque = v + V_FED;
    return own;
}
