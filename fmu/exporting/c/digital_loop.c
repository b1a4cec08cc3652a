/* A whole digital servo loop: planned motion, controller with its delay, axis with friction.
 *
 * Samples run and torques act at their own times, in the order of time, whatever steps a host
 * takes; what is due at one time is done in the order sample, torque.
 */

#include "digital.c"
#include "events.c"
#include "piecewise.c"

#define SAME_TIME (1e-8 * SAMPLE_TIME) /* what hosts are off by that add up t += h */
#define ON_BREAK 1e-12                 /* of a time: as near to a break counts as on it */
#define SLACK (1e-9 * SHORTER_STEP)    /* marks of time this near are one */

/* Of the memory: the time since the start that has been reached, how many torques have acted, and
 * those that wait. */
enum { REACHED = AFTER_TURNS, ACTED, WAITING };

static double tick_time(const State *s, int64_t tick) {
    return s->start + (double)tick * SAMPLE_TIME;
}

static double at_break(double t, double a_break) {
    return magnitude(t - a_break) <= ON_BREAK * larger(magnitude(t), 1e-3) ? a_break : t;
}

/* A time, or the break from which rounding has parted it. */
static double on_break(double t) {
    size_t behind = jounce_breaks_up_to(&planned, t);
    double moved = behind <= planned.count ? at_break(t, planned.breaks[behind]) : t;
    return moved == t && behind > 0 ? at_break(t, planned.breaks[behind - 1]) : moved;
}

/* The command and its derivatives. */
static void commanded(double t, double *command) {
    jounce_evaluate_at(&planned, t, 0.0, OWN_ORDER, command);
}

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

static void sample(State *s) {
    double z[N_Z], command[N_COMMAND], ahead[N_COMMAND], out[3];
    double t = on_break(tick_time(s, s->ticks));
    jounce_controller own = own_controller(s);
    commanded(t, command);
    commanded(OWN_LEAD > 0.0 ? on_break(t + OWN_LEAD) : t, ahead);
    gather(s, s->value[V_U], z);
    jounce_controller_sample(&own, s->value + V_OWN, row_of(seen_row, z), row_of(moved_row, z),
                             command, ahead, out);
    s->memory[WAITING + s->ticks % N_WAITING] = out[2];
    s->ticks += 1;
}

static double sample_time(const State *s) {
    return (double)s->ticks * SAMPLE_TIME;
}

static double actuation_time(const State *s) {
    return s->memory[ACTED] < (double)s->ticks ? s->memory[ACTED] * SAMPLE_TIME + OWN_DELAY
                                               : INFINITE;
}

static void do_what_is_due(State *s) {
    double until = s->memory[REACHED] + SLACK;
    while (sample_time(s) <= until) {
        sample(s);
    }
    while (actuation_time(s) <= until) {
        s->value[V_U] = s->memory[WAITING + (int64_t)s->memory[ACTED] % N_WAITING];
        s->memory[ACTED] += 1.0;
    }
}

/* A time, or that of the sample from which a host's rounding has parted it. */
static double on_sample(double t) {
    double nearest = (double)(int64_t)(t / SAMPLE_TIME + 0.5) * SAMPLE_TIME;
    return magnitude(t - nearest) < SAME_TIME ? nearest : t;
}

static void core_initialize(State *s) {
    s->memory[REACHED] = 0.0;
    s->memory[ACTED] = 0.0;
    s->value[V_U] = HOLDING;
    start_axis(s);
}

static void core_outputs(State *s, int running) {
    (void)running;
    put_out(s);
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    double end = t + h - s->start;
    const char *problem = NULL;
    if ((end - sample_time(s)) / SAMPLE_TIME > MOST_STEPS) {
        return "the step holds more than 1e9 samples: use a shorter one";
    }
    end = on_sample(end);
    while (!problem && s->memory[REACHED] < end - SLACK) {
        double until;
        do_what_is_due(s);
        until = smaller(smaller(end, sample_time(s)), actuation_time(s));
        problem = move_axis(s, cache, s->value[V_U], until - s->memory[REACHED]);
        s->memory[REACHED] = until;
    }
    return problem;
}
