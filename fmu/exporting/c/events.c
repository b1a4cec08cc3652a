/* The axis that the tables hold, exact from event to event: friction sticks and slides, ripple goes
 * from line to line of its table.
 *
 * Its z are the states in the values, the disturbances, how far the ripple's table is shifted, the
 * torque and 1. The work space keeps what depends on the tables alone.
 */

#include "automaton.c"
#include "first_fall.c"

#define MOST_STEPS 1e9

/* Of the memory; TURNS: the whole periods by which the ripple's table is shifted. */
enum { MODE, TURNS, AFTER_TURNS };

/* Modes come in lines of the ripple: those that stick (or all, where there is no friction), then
 * those that slide forwards, then backwards. */
enum { N_LINES = N_MODES / N_FRICTION };

static jounce_automaton own_automaton(void) {
    jounce_automaton own = {N_Z,
                            N_MOVING,
                            N_MODES,
                            N_GUARDS,
                            (const double *)mode_rates,
                            (const double *)guard_rows,
                            (const double *)guard_next,
                            (const double *)event_onto,
                            (const double *)event_along};
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
    z[N_MOVING + 2] = s->memory[TURNS];
    z[N_Z - 2] = torque;
    z[N_Z - 1] = 1.0;
}

/* It starts to slide where it moves, on the line of the ripple's table where it is. */
static void start_axis(State *s) {
    double z[N_Z], rate, position, turns;
    int direction, line = 0;
    s->memory[TURNS] = 0.0;
    gather(s, 0.0, z);
    rate = row_of(rate_row, z);
    direction = N_FRICTION == 1 ? 0 : rate > 0.0 ? 1 : rate < 0.0 ? 2 : 0;
    position = row_of(motor_row, z);
    turns = whole_below((position - ripple_edges[0]) / RIPPLE_PERIOD) * RIPPLE_PERIOD;
    while (line < N_LINES - 1 && ripple_edges[line + 1] <= position - turns) {
        line += 1;
    }
    s->memory[MODE] = (double)(direction * N_LINES + line);
    s->memory[TURNS] = turns;
}

static void put_axis_out(State *s, double torque) {
    double z[N_Z];
    int i;
    gather(s, torque, z);
    for (i = 0; i < N_OUTPUTS; i++) {
        s->value[V_OUTPUT + i] = row_of(output_rows[i], z);
    }
#if N_FRICTION > 1
    i = (int)s->memory[MODE] / N_LINES;
    s->value[V_SLIDING] = i == 2 ? -1.0 : (double)i;
#endif
}

/* Go on by h under a torque that is held; returns what went wrong, or NULL. */
static const char *move_axis(State *s, Cache *cache, double torque, double h) {
    double z[N_Z];
    jounce_automaton own = own_automaton();
    jounce_run run = {&own, {LONGER_STEP, SHORTER_STEP}, NULL, NULL, 0, 0, -1, NULL, 0, 0};
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
    s->memory[TURNS] = z[N_MOVING + 2];
    return status == JOUNCE_OK ? NULL : "friction sticks and slides for ever at one instant";
}
