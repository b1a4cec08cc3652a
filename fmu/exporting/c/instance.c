/* An instance whatever the version of FMI: phases, checks, steps. */

#include "messages.c"

enum { OK, WARNING, DISCARD, FAILED };

typedef struct Instance {
    State now, trial;
    Cache cache;
    int stale;  /* outputs have to be computed again */
    int events; /* whether to report them */
    char name[128];
    void *environment;
    void (*logger)(void);
} Instance;

/* Defined by the wrapper. */
static void tell(Instance *it, int status, const char *text);

static int fail(Instance *it, const char *text) {
    tell(it, FAILED, text);
    return FAILED;
}

static int fail_with(Instance *it, const char *what, double number, const char *expected,
                     double bound) {
    Message message = {{0}, 0};
    add(&message, what);
    add(&message, " = ");
    add_number(&message, number);
    add(&message, expected);
    if (is_finite(bound)) {
        add_number(&message, bound);
    }
    return fail(it, message.text);
}

static int same_text(const char *a, const char *b) {
    while (*a && *a == *b) {
        a++;
        b++;
    }
    return *a == *b;
}

static void event(Instance *it, const char *text) {
    if (it->events) {
        tell(it, OK, text);
    }
}

static int in_phase(Instance *it, const char *call, unsigned phases) {
    Message message = {{0}, 0};
    static const char *const names[] = {"instantiated", "initialization mode", "step mode",
                                        "terminated"};
    if (it && phases >> it->now.phase & 1u) {
        return 1;
    }
    if (it) {
        add(&message, call);
        add(&message, " is not allowed in this phase: ");
        add(&message, names[it->now.phase]);
        fail(it, message.text);
    }
    return 0;
}

static void reset(Instance *it) {
    int i;
    State *now = &it->now; /* in place: a large copy on the stack would need a run-time library */
    for (i = 0; i < N_VARIABLES; i++) {
        now->value[i] = variables[i].start;
    }
    for (i = 0; i < N_MEMORY; i++) {
        now->memory[i] = 0.0;
    }
    now->start = now->time = 0.0;
    now->stop = -1.0;
    now->ticks = 0;
    now->phase = INSTANTIATED;
    it->stale = 1;
    event(it, "reset");
}

static void refresh(Instance *it) {
    if (it->stale) {
        if (it->now.phase <= INITIALIZING) {
            core_initialize(&it->now);
        }
        core_outputs(&it->now, it->now.phase > INITIALIZING);
        it->stale = 0;
    }
}

static int set_value(Instance *it, size_t reference, double value) {
    const Variable *variable = variables + reference - 1;
    int before = START | TUNABLE | INPUT, later = TUNABLE | INPUT;
    Message message = {{0}, 0};
    if (reference < 1 || reference > N_VARIABLES) {
        return fail_with(it, "value reference", (double)reference, ": unknown", 1.0 / 0.0);
    }
    if (!(variable->flags & (it->now.phase <= INITIALIZING ? before : later))) {
        add(&message, variable->name);
        add(&message, variable->flags & before ? ": may be set only before the simulation starts"
                                               : ": cannot be set");
        return fail(it, message.text);
    }
    if (!is_finite(value)) {
        return fail_with(it, variable->name, value, ": expected a finite number", 1.0 / 0.0);
    }
    if (value < variable->least) {
        return fail_with(it, variable->name, value, " is below its minimum ", variable->least);
    }
    if (value > variable->most) {
        return fail_with(it, variable->name, value, " is above its maximum ", variable->most);
    }
    it->now.value[reference - 1] = value;
    it->stale = 1;
    return OK;
}

static int get_value(Instance *it, size_t reference, double *value) {
    if (reference < 1 || reference > N_VARIABLES) {
        return fail_with(it, "value reference", (double)reference, ": unknown", 1.0 / 0.0);
    }
    refresh(it);
    *value = it->now.value[reference - 1];
    if (!is_finite(*value)) {
        return fail_with(it, variables[reference - 1].name, *value,
                         ": it leaves the range of a double", 1.0 / 0.0);
    }
    return OK;
}

static int set_times(Instance *it, double start, int stop_defined, double stop) {
    if (!is_finite(start) || (stop_defined && !(stop >= start))) {
        return fail_with(it, "start time", start, ": expected a finite time, at most ",
                         stop_defined ? stop : 1.0 / 0.0);
    }
    it->now.start = it->now.time = start;
    it->now.stop = stop_defined ? stop : start - 1.0 - magnitude(start);
    it->stale = 1;
    return OK;
}

static int all_finite(const State *state) {
    int i;
    for (i = 0; i < N_VARIABLES; i++) {
        if (!is_finite(state->value[i])) {
            return 0;
        }
    }
    for (i = 0; i < N_MEMORY; i++) {
        if (!is_finite(state->memory[i])) {
            return 0;
        }
    }
    return 1;
}

static int finish_initialization(Instance *it) {
    it->stale = 1;
    refresh(it);
    if (!all_finite(&it->now)) {
        return fail(it, "the start values make a variable leave the range of a double");
    }
    it->now.phase = STEPPING;
    event(it, "initialized");
    return OK;
}

/* A step that fails changes nothing. */
static int take_step(Instance *it, double t, double h) {
    const char *problem;
    if (!is_finite(h) || h <= 0.0) {
        return fail_with(it, "communication step", h, ": expected a positive, finite time",
                         1.0 / 0.0);
    }
    if (!is_finite(t) || magnitude(t - it->now.time) > 0.5 * h + 1e-9 * magnitude(t)) {
        return fail_with(it, "communication point", t, ": expected the end of the last step, ",
                         it->now.time);
    }
    if (!(t + h > t)) {
        return fail_with(it, "communication step", h, " is lost in the rounding of time ", t);
    }
    if (it->now.stop >= it->now.start && t + h > it->now.stop + 0.01 * h) {
        return fail_with(it, "end of the step", t + h, " is beyond the stop time ", it->now.stop);
    }
    it->trial = it->now;
    it->trial.time = t + h;
    problem = core_step(&it->trial, &it->cache, t, h);
    if (problem) {
        return fail(it, problem);
    }
    core_outputs(&it->trial, 1);
    if (!all_finite(&it->trial)) {
        return fail_with(it, "step to time", t + h, ": a variable leaves the range of a double",
                         1.0 / 0.0);
    }
    it->now = it->trial;
    it->stale = 0;
    return OK;
}

static int add_partials(Instance *it, size_t unknown, size_t known, double seed, double *sum) {
#if defined(HAS_PARTIALS)
    if (unknown < 1 || unknown > N_VARIABLES || known < 1 || known > N_VARIABLES ||
        !(variables[unknown - 1].flags & (OUTPUT | DERIVATIVE)) ||
        !(variables[known - 1].flags & (INPUT | STATE))) {
        return fail(it, "partial derivatives are those of outputs and state derivatives by inputs "
                        "and states");
    }
    *sum += core_partial(&it->now, (int)unknown - 1, (int)known - 1) * seed;
    return OK;
#else
    (void)unknown, (void)known, (void)seed, (void)sum;
    return fail(it, "this block provides no partial derivatives");
#endif
}

#include "snapshots.c"
