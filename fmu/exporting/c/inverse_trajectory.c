/* A motion planned beforehand, and what the exact inverse of a damped axis remembers of it. */

#include "planned_motion.c"

#include "inverse.c"

static void core_outputs(State *s, int running) {
    (void)running;
    put_motion_out(s);
    remembered(own_time(s), early(s), s->value + V_INVERSE_TORQUE);
}
