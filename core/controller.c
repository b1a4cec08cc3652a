/* A sampled PID controller with feedforward of the command's acceleration. */
#include "jounce.h"

double jounce_pid_output(const jounce_pid *pid, double integral, double e, double e_rate,
                         double r_acceleration) {
    return pid->kp * e + pid->ki * jounce_pid_integral(pid, integral, e) + pid->kr * e_rate +
           pid->inertia * r_acceleration;
}

double jounce_pid_integral(const jounce_pid *pid, double integral, double e) {
    return integral + pid->dt * e;
}
