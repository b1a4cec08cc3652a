/* An axis behind a computing delay, under a torque that is sampled and held. */

#include "waiting.c"

static double sampled_torque(State *s) {
    return clamp(s->value[V_U], -OWN_LIMIT, OWN_LIMIT);
}

static void core_outputs(State *s, int running) {
    (void)running;
    put_axis_out(s, s->value[V_ACTING]);
}
