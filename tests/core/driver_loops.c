/* Random digital loops with friction, to be run under sanitizers.
 *
 * Usage: driver_loops COUNT [SEED]. All states must be finite, a motor that sticks be exactly still,
 * one that slips not go the other way. What fails is printed with its seed.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "jounce.h"

enum { N = 6, MOVING = 4, MODES = 3, GUARDS = 2, SAMPLES = 60, ROOM = 4000, SECTIONS = 1 };

static uint64_t seed;

static double uniform(double low, double high) { /* xorshift64* */
    seed ^= seed >> 12;
    seed ^= seed << 25;
    seed ^= seed >> 27;
    return low + (high - low) * ((double)((seed * UINT64_C(2685821657736338717)) >> 11) /
                                 9007199254740992.0);
}

/* States y, v, twist and its rate; u and 1 are held. Modes: stick, slip forwards, backwards. */
typedef struct {
    double rates[MODES * MOVING * N], rows[MODES * GUARDS * N], next[MODES * GUARDS];
    double onto[MODES * GUARDS * N], along[MODES * GUARDS * N];
    double z[N], motor[N], section[5 * SECTIONS], gains[4], torque[4];
    double commands[SAMPLES * 4], state[JOUNCE_CONTROLLER_STATE(SECTIONS)], out[3 * SAMPLES];
    double work[JOUNCE_AUTOMATON_WORK(N, MOVING, MODES, GUARDS)];
    double segments[ROOM * (N + 2)];
} Memory;

static void make_axis(Memory *m, double stiff, double loss, double share, double coulomb,
                      double stick) {
    int mode, j;
    for (mode = 0; mode < MODES; mode++) {
        double *a = m->rates + mode * MOVING * N, *row = m->rows + mode * GUARDS * N;
        double way = mode == 1 ? 1.0 : mode == 2 ? -1.0 : 0.0;
        double push[N] = {0.0, 0.0, share * stiff, share * loss, 1.0, -way * coulomb};
        a[1] = 1.0;
        a[2 * N + 3] = 1.0;
        for (j = 0; j < N; j++) {
            a[N + j] = mode > 0 ? push[j] : 0.0;
            a[3 * N + j] = (j == 2 ? -stiff : j == 3 ? -loss : 0.0) - a[N + j];
        }
        m->next[mode * GUARDS] = mode > 0 ? 0.0 : 1.0;
        m->next[mode * GUARDS + 1] = mode > 0 ? -1.0 : 2.0;
        if (mode > 0) {
            row[1] = way;
            m->onto[mode * GUARDS * N + 1] = -1.0;
            m->onto[mode * GUARDS * N + 3] = 1.0;
            m->along[mode * GUARDS * N + 1] = 1.0;
            continue;
        }
        for (j = 0; j < N; j++) {
            row[j] = (j == 5 ? stick : 0.0) - push[j];
            row[N + j] = (j == 5 ? stick : 0.0) + push[j];
        }
    }
    m->z[5] = 1.0;
    m->motor[0] = 1.0;
}

static void make_controller(Memory *m, jounce_controller *c, double omega) {
    int k;
    memset(c, 0, sizeof *c);
    c->law = uniform(0.0, 1.0) < 0.5 ? JOUNCE_PID : JOUNCE_CASCADE;
    c->anti_windup = (int)uniform(0.0, 4.0);
    c->sections = SECTIONS;
    c->order = 3;
    c->dt = uniform(0.02, 0.2) / omega;
    c->kp = c->law == JOUNCE_PID ? omega * omega : omega;
    c->ki = 0.2 * c->kp * omega;
    c->kr = omega;
    c->rate_filter = uniform(0.0, 2.0) * c->dt;
    c->position_gain = 0.5 * omega;
    c->velocity_feedforward = 1.0;
    c->limit = uniform(1.0, 20.0);
    c->tracking_time = uniform(1.0, 20.0) * c->dt;
    c->integral_limit = uniform(0.5, 5.0);
    c->encoder_step = uniform(0.0, 1.0) < 0.5 ? 0.0 : 1e-3;
    m->section[0] = 0.6;
    m->section[1] = 0.2;
    m->section[3] = -0.2;
    m->gains[0] = 1.0;
    m->torque[2] = 1.0;
    c->section = m->section;
    c->position = m->gains;
    c->torque = m->torque;
    for (k = 0; k < SAMPLES; k++) {
        double t = (double)k * c->dt * omega;
        m->commands[4 * k] = t < 1.0 ? 0.5 * t * t : t < 2.0 ? t - 0.5 : 1.5;
    }
}

static int wrong(const Memory *m, size_t count) {
    size_t i;
    int j;
    for (i = 0; i < count; i++) {
        const double *row = m->segments + i * (N + 2);
        double v = row[3];
        for (j = 0; j < N + 2; j++) {
            if (!(row[j] - row[j] == 0.0)) {
                return 1;
            }
        }
        if ((row[1] == 0.0 && v != 0.0) || (row[1] == 1.0 && v < -1e-12) ||
            (row[1] == 2.0 && v > 1e-12)) {
            return 1;
        }
    }
    return 0;
}

static int runs(Memory *m) {
    jounce_automaton automaton = {N, MOVING, MODES, GUARDS, m->rates, m->rows, m->next,
                                  m->onto, m->along};
    jounce_controller controller;
    jounce_loop loop;
    jounce_run run;
    jounce_status status;
    double omega = uniform(2.0, 8.0), coulomb = uniform(0.0, 2.0), size, rest;
    memset(m, 0, sizeof *m);
    size = omega * uniform(3.0, 20.0);
    make_axis(m, size * size, uniform(0.0, 0.1) * size, uniform(0.1, 0.8), coulomb,
              coulomb * uniform(1.0, 1.5));
    make_controller(m, &controller, omega);
    memset(&loop, 0, sizeof loop);
    memset(&run, 0, sizeof run);
    loop.controller = &controller;
    loop.delay = uniform(0.0, 2.5) * controller.dt;
    loop.duration = SAMPLES * controller.dt;
    loop.samples = SAMPLES;
    loop.held = 4;
    loop.position = loop.motor = m->motor;
    loop.commands = loop.ahead = m->commands;
    loop.times = loop.values = m->gains;
    rest = loop.delay - (double)(int)(loop.delay / controller.dt) * controller.dt;
    while (controller.dt * size > 1.0) {
        controller.dt *= 0.5;
        rest *= 0.5;
    }
    run.automaton = &automaton;
    run.steps[0] = controller.dt - rest > rest ? controller.dt - rest : rest;
    run.steps[1] = controller.dt - rest > rest ? rest + 1e-9 : controller.dt - rest;
    run.work = m->work;
    run.z = m->z;
    run.segments = m->segments;
    run.room = ROOM;
    jounce_prepare(&run);
    status = jounce_run_loop(&loop, &run, m->state, m->out);
    return (status != JOUNCE_OK && status != JOUNCE_FULL) || wrong(m, run.count);
}

int main(int count, char **arguments) {
    static Memory memory;
    long problems = count > 1 ? atol(arguments[1]) : 2000, i, bad = 0;
    uint64_t first = count > 2 ? strtoull(arguments[2], NULL, 10) : UINT64_C(20260101);
    for (i = 0; i < problems; i++) {
        seed = first + (uint64_t)i * UINT64_C(7919) + 1;
        if (runs(&memory)) {
            printf("a loop failed: driver_loops 1 %" PRIu64 "\n",
                   first + (uint64_t)i * UINT64_C(7919));
            bad += 1;
        }
    }
    printf("%ld loops, %ld failed\n", problems, bad);
    return bad > 0;
}
