/* An axis with friction, torque limit and load, under a torque that is held during the step. */

#include "events.c"

static double driven(const State *s) {
    return clamp(s->value[V_U], -OWN_LIMIT, OWN_LIMIT);
}

static void core_initialize(State *s) {
    start_axis(s);
}

static void core_outputs(State *s, int running) {
    (void)running;
    put_axis_out(s, driven(s));
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    (void)t;
    return move_axis(s, cache, driven(s), h);
}
