/* Torques that wait: what is sampled every SAMPLE_TIME acts OWN_DELAY later, on an axis that goes
 * on exactly in between.
 *
 * Samples run and torques act at their own times, in the order of time, whatever steps a host
 * takes; what is due at one time is done in the order sample, torque.
 */

#include "events.c"

#define SAME_TIME (1e-8 * SAMPLE_TIME) /* what hosts are off by that add up t += h */
#define SLACK (1e-9 * SHORTER_STEP)    /* marks of time this near are one */

/* Of the memory: the time since the start that has been reached, how many torques have acted, and
 * those that wait. */
enum { REACHED = AFTER_TURNS, ACTED, WAITING };

/* Returns the torque of a sample. */
static double sampled_torque(State *s);

static double tick_time(const State *s, int64_t tick) {
    return s->start + (double)tick * SAMPLE_TIME;
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
        s->memory[WAITING + s->ticks % N_WAITING] = sampled_torque(s);
        s->ticks += 1;
    }
    while (actuation_time(s) <= until) {
        s->value[V_ACTING] = s->memory[WAITING + (int64_t)s->memory[ACTED] % N_WAITING];
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
    s->value[V_ACTING] = HOLDING;
    start_axis(s);
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    double end = t + h - s->start;
    const char *problem = NULL;
    if ((t + h - tick_time(s, s->ticks)) / SAMPLE_TIME > MOST_STEPS) {
        return "the step holds more than 1e9 samples: use a shorter one";
    }
    end = on_sample(end);
    while (!problem && s->memory[REACHED] < end - SLACK) {
        double until;
        do_what_is_due(s);
        until = smaller(smaller(end, sample_time(s)), actuation_time(s));
        problem = move_axis(s, cache, s->value[V_ACTING], until - s->memory[REACHED]);
        s->memory[REACHED] = until;
    }
    return problem;
}
