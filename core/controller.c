/* Digital controllers: a PID with feedforward of the acceleration, and the whole of a drive's. */
#include "jounce.h"
#include "numeric.h"

double jounce_pid_output(const jounce_pid *pid, double integral, double e, double e_rate,
                         double r_acceleration) {
    return pid->kp * e + pid->ki * jounce_pid_integral(pid, integral, e) + pid->kr * e_rate +
           pid->inertia * r_acceleration;
}

double jounce_pid_integral(const jounce_pid *pid, double integral, double e) {
    return integral + pid->dt * e;
}

/* --- the whole digital controller ---------------------------------------------------------------- */

/* Places in the state, before two numbers of each filter's section. */
enum { STARTED, INTEGRAL, PAST, RATE, SECTIONS };

static double reading(const jounce_controller *c, double position) {
    return c->encoder_step > 0.0
               ? c->encoder_step * whole_below(position / c->encoder_step + 0.5)
               : position;
}

static double weighed(const double *gains, const double *command, int order) {
    double sum = 0.0;
    int k;
    for (k = 0; k <= order; k++) {
        sum += gains[k] * command[k];
    }
    return sum;
}

/* One section, transposed direct form II; `memory` are its two numbers. */
static double filtered(const double *section, double *memory, double x) {
    double y = section[0] * x + memory[0];
    memory[0] = section[1] * x - section[3] * y + memory[1];
    memory[1] = section[2] * x - section[4] * y;
    return y;
}

/* The rate of a signal that is known once a sample, behind its filter. */
static double rate_of(const jounce_controller *c, double *state, double signal) {
    double past = state[STARTED] != 0.0 ? state[PAST] : signal;
    state[RATE] = (c->rate_filter * state[RATE] + signal - past) / (c->rate_filter + c->dt);
    state[PAST] = signal;
    state[STARTED] = 1.0;
    return state[RATE];
}

static void unwind(const jounce_controller *c, double *state, double integrated, double w,
                   double u) {
    if (c->anti_windup == JOUNCE_CONDITIONAL && u != w && w * integrated > 0.0) {
        state[INTEGRAL] -= c->dt * integrated;
    }
    if (c->anti_windup == JOUNCE_BACK_CALCULATION && c->ki != 0.0) {
        state[INTEGRAL] += c->dt / c->tracking_time * (u - w) / c->ki;
    }
    if (c->anti_windup == JOUNCE_CLAMP && c->ki != 0.0) {
        double most = c->integral_limit / magnitude(c->ki);
        state[INTEGRAL] = clamp(state[INTEGRAL], -most, most);
    }
}

void jounce_controller_sample(const jounce_controller *c, double *state, double position,
                              double motor, const double *command, const double *ahead,
                              double *out) {
    double reference = weighed(c->position, command, c->order);
    double e = reference - reading(c, position), integrated = e, w;
    int i;
    if (c->law == JOUNCE_CASCADE) {
        double rate = rate_of(c, state, reading(c, motor));
        integrated = c->position_gain * e + c->velocity_feedforward * command[1] - rate;
        state[INTEGRAL] += c->dt * integrated;
        w = c->kp * integrated + c->ki * state[INTEGRAL];
    } else {
        double rate = rate_of(c, state, reference - reading(c, motor));
        state[INTEGRAL] += c->dt * e;
        w = c->kp * e + c->ki * state[INTEGRAL] + c->kr * rate;
    }
    for (i = 0; i < c->sections; i++) {
        w = filtered(c->section + 5 * i, state + SECTIONS + 2 * i, w);
    }
    w += weighed(c->torque, ahead, c->order);
    w += c->friction * ((double)(ahead[1] > 0.0) - (double)(ahead[1] < 0.0));
    out[0] = e;
    out[1] = w;
    out[2] = clamp(w, -c->limit, c->limit);
    unwind(c, state, integrated, w, out[2]);
}
