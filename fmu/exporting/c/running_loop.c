/* What whole digital servo loops share: planned motion, controller with its delay, axis. */

#include "digital.c"
#include "piecewise.c"
#include "waiting.c"

#define ON_BREAK 1e-12 /* of a time: as near to a break counts as on it */

static double at_break(double t, double a_break) {
    return magnitude(t - a_break) <= ON_BREAK * larger(magnitude(t), 1e-3) ? a_break : t;
}

/* A time, or the break from which rounding has parted it. */
static double on_break(double t) {
    size_t behind = jounce_breaks_up_to(&planned, t);
    double moved = behind <= planned.count ? at_break(t, planned.breaks[behind]) : t;
    return moved == t && behind > 0 ? at_break(t, planned.breaks[behind - 1]) : moved;
}

/* The N_COMMAND numbers of a time. */
static void commanded(double t, double *command);

static void put_out(State *s) {
    double *v = s->value, command[N_COMMAND > 3 ? N_COMMAND : 3];
    int i;
    jounce_evaluate_at(&planned, on_break(s->start + s->memory[REACHED]), 0.0, 2, command);
    for (i = 0; i < 3; i++) {
        v[V_R + i] = command[i];
    }
    put_axis_out(s, v[V_U]);
    v[V_E] = v[V_R] - v[V_OUTPUT];
}

static double sampled_torque(State *s) {
    double z[N_Z], command[N_COMMAND], ahead[N_COMMAND], fed[N_COMMAND], out[3];
    double t = on_break(tick_time(s, s->ticks));
    jounce_controller own = own_controller(s, fed);
    commanded(t, command);
    commanded(OWN_LEAD > 0.0 ? on_break(t + OWN_LEAD) : t, ahead);
    gather(s, s->value[V_U], z);
    jounce_controller_sample(&own, s->value + V_OWN, row_of(seen_row, z), row_of(moved_row, z),
                             command, ahead, out);
    return out[2];
}

static void core_outputs(State *s, int running) {
    (void)running;
    put_out(s);
}
