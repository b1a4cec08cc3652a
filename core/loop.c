/* A servo loop over time: samples, actuation and settings in the order of time. */
#include "jounce.h"
#include "numeric.h"

/* What comes next of each. */
typedef struct {
    int setting, sample, actuation;
    double slack;
} Next;

static double row_of(const double *row, const double *z, int n) {
    double sum = 0.0;
    int i;
    for (i = 0; i < n; i++) {
        sum += row[i] * z[i];
    }
    return sum;
}

static void set(const jounce_loop *loop, int which, double *z) {
    const double *values = loop->values + which * loop->width;
    int i;
    for (i = 0; i < loop->width; i++) {
        if (values[i] == values[i]) {
            z[loop->place + i] = values[i];
        }
    }
}

static void sample(const jounce_loop *loop, jounce_run *run, int k, double *state, double *out) {
    const jounce_controller *c = loop->controller;
    int n = run->automaton->states, width = c->order + 1;
    double noise = loop->noise != 0 ? loop->noise[k] : 0.0;
    jounce_controller_sample(c, state, row_of(loop->position, run->z, n) + noise,
                             row_of(loop->motor, run->z, n) + noise, loop->commands + k * width,
                             loop->ahead + k * width, out + 3 * k);
}

static double sample_time(const jounce_loop *loop, int k) {
    return k < loop->samples ? (double)k * loop->controller->dt : INFINITE;
}

static double actuation_time(const jounce_loop *loop, int k) {
    return k < loop->samples ? (double)k * loop->controller->dt + loop->delay : INFINITE;
}

static double setting_time(const jounce_loop *loop, int k) {
    return k < loop->settings ? loop->times[k] : INFINITE;
}

/* All that is due at t: settings first, then a sample, then what acts. */
static void do_what_is_due(const jounce_loop *loop, jounce_run *run, double t, Next *next,
                           double *state, double *out) {
    double until = t + next->slack;
    while (setting_time(loop, next->setting) <= until) {
        set(loop, next->setting, run->z);
        next->setting += 1;
    }
    while (sample_time(loop, next->sample) <= until) {
        sample(loop, run, next->sample, state, out);
        next->sample += 1;
    }
    while (next->actuation < next->sample && actuation_time(loop, next->actuation) <= until) {
        run->z[loop->held] = out[3 * next->actuation + 2];
        next->actuation += 1;
    }
}

jounce_status jounce_run_loop(const jounce_loop *loop, jounce_run *run, double *state,
                              double *out) {
    Next next = {0, 0, 0, 0.0};
    double t = 0.0;
    next.slack = 1e-9 * run->steps[1];
    while (t < loop->duration - next.slack) {
        double until = loop->duration;
        jounce_status status;
        do_what_is_due(loop, run, t, &next, state, out);
        until = smaller(until, setting_time(loop, next.setting));
        until = smaller(until, sample_time(loop, next.sample));
        until = smaller(until, actuation_time(loop, next.actuation));
        status = jounce_advance(run, t, until - t);
        if (status != JOUNCE_OK) {
            return status;
        }
        t = until;
    }
    do_what_is_due(loop, run, t, &next, state, out);
    return JOUNCE_OK;
}
