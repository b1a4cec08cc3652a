/* The axis that the tables hold, exact from event to event: friction sticks and slides.
 *
 * Its z are the states in the values, the disturbances, the torque and 1. The work space keeps what
 * depends on the tables alone.
 */

#include "automaton.c"
#include "first_fall.c"

#define MOST_STEPS 1e9

enum { MODE, AFTER_MODE }; /* of the memory: 0 sticks (or there is no friction), 1 and 2 slide */

static jounce_automaton own_automaton(void) {
    jounce_automaton own = {N_Z,           N_MOVING,        N_MODES,       N_GUARDS,
                            mode_rates[0][0], guard_rows[0][0], guard_next[0], mode_onto[0],
                            mode_along[0]};
    return own;
}

static double row_of(const double *row, const double *z) {
    double sum = 0.0;
    int i;
    for (i = 0; i < N_Z; i++) {
        sum += row[i] * z[i];
    }
    return sum;
}

static void gather(const State *s, double torque, double *z) {
    int i;
    for (i = 0; i < N_MOVING; i++) {
        z[i] = s->value[V_STATE + i];
    }
    z[N_MOVING] = s->value[V_D];
    z[N_MOVING + 1] = s->value[V_D + 1];
    z[N_MOVING + 2] = torque;
    z[N_MOVING + 3] = 1.0;
}

/* It starts to slide where it moves. */
static void start_axis(State *s) {
    double z[N_Z], rate;
    gather(s, 0.0, z);
    rate = row_of(mode_along[0], z);
    s->memory[MODE] = rate > 0.0 ? 1.0 : rate < 0.0 ? 2.0 : 0.0;
}

static void put_axis_out(State *s, double torque) {
    double z[N_Z];
    int i;
    gather(s, torque, z);
    for (i = 0; i < N_OUTPUTS; i++) {
        s->value[V_OUTPUT + i] = row_of(output_rows[i], z);
    }
#if N_MODES > 1
    s->value[V_SLIDING] = s->memory[MODE] == 2.0 ? -1.0 : s->memory[MODE];
#endif
}

/* Go on by h under a torque that is held; returns what went wrong, or NULL. */
static const char *move_axis(State *s, Cache *cache, double torque, double h) {
    double z[N_Z];
    jounce_automaton own = own_automaton();
    jounce_run run = {&own, {LONGER_STEP, SHORTER_STEP}, NULL, NULL, 0, 0, NULL, 0, 0};
    jounce_status status;
    int i;
    if (h / SHORTER_STEP > MOST_STEPS) {
        return "the step is too long for the axis: use a shorter one";
    }
    gather(s, torque, z);
    run.work = cache->work + 1;
    run.z = z;
    run.mode = (int)s->memory[MODE];
    if (cache->work[0] == 0.0) {
        jounce_prepare(&run);
        cache->work[0] = 1.0;
    }
    status = jounce_advance(&run, 0.0, h);
    for (i = 0; i < N_MOVING; i++) {
        s->value[V_STATE + i] = z[i];
    }
    s->memory[MODE] = (double)run.mode;
    return status == JOUNCE_OK ? NULL : "friction sticks and slides for ever at one instant";
}
