/* A motion planned beforehand, as a function of time. */

#include "planned_motion.c"

static void core_outputs(State *s, int running) {
    (void)running;
    put_motion_out(s);
}
