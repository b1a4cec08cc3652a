/* The functions that are the same in FMI 2.0 and 3.0, but for the names of types and functions.
 *
 * Whoever includes this has defined FMI(name), a name with its prefix, and `tell`.
 */

#define BEFORE (1u << INSTANTIATED | 1u << INITIALIZING)
#define RUNNING (1u << STEPPING)
#define ANY (BEFORE | RUNNING | 1u << TERMINATED)
#define ALLOWED_IN(phases)                                                                         \
    Instance *it = instance;                                                                       \
    if (!in_phase(it, __func__, phases)) {                                                         \
        return FMI(Error);                                                                         \
    }
#define FAIL(text) (FMI(Status))fail(it, text)

const char *FMI(GetVersion)(void) {
    return FMI(Version);
}

FMI(Status) FMI(SetDebugLogging)(FMI(Instance) instance, FMI(Boolean) on, size_t n,
                                 const FMI(String) categories[]) {
    size_t i;
    int events = n == 0;
    ALLOWED_IN(ANY)
    for (i = 0; i < n; i++) {
        if (same_text(categories[i], "logEvents")) {
            events = 1;
        } else if (!same_text(categories[i], "logStatusError")) {
            return FAIL("unknown log category");
        }
    }
    it->events = on && events;
    return FMI(OK);
}

/* The last step of instantiation: `it` itself, or NULL where there is a problem. */
static Instance *finished(Instance *it, const char *problem, int logging) {
    if (problem) {
        fail(it, problem);
        free_memory(it);
        return NULL;
    }
    reset(it);
    it->events = logging;
    return it;
}

void FMI(FreeInstance)(FMI(Instance) instance) {
    free_memory(instance);
}

FMI(Status) FMI(ExitInitializationMode)(FMI(Instance) instance) {
    ALLOWED_IN(1u << INITIALIZING)
    return (FMI(Status))finish_initialization(it);
}

FMI(Status) FMI(Terminate)(FMI(Instance) instance) {
    ALLOWED_IN(RUNNING)
    refresh(it);
    it->now.phase = TERMINATED;
    return FMI(OK);
}

FMI(Status) FMI(Reset)(FMI(Instance) instance) {
    ALLOWED_IN(ANY)
    reset(it);
    return FMI(OK);
}

FMI(Status) FMI(GetFMUState)(FMI(Instance) instance, FMI(FMUState) *snapshot) {
    ALLOWED_IN(ANY)
    if (!*snapshot) {
        *snapshot = new_memory(sizeof(State));
    }
    if (!*snapshot) {
        return FAIL("out of memory");
    }
    *(State *)*snapshot = it->now;
    return FMI(OK);
}

FMI(Status) FMI(SetFMUState)(FMI(Instance) instance, FMI(FMUState) snapshot) {
    ALLOWED_IN(ANY)
    if (!snapshot) {
        return FAIL("no state given");
    }
    restore(it, snapshot);
    return FMI(OK);
}

FMI(Status) FMI(FreeFMUState)(FMI(Instance) instance, FMI(FMUState) *snapshot) {
    (void)instance;
    if (snapshot) {
        free_memory(*snapshot);
        *snapshot = NULL;
    }
    return FMI(OK);
}

FMI(Status) FMI(SerializedFMUStateSize)(FMI(Instance) instance, FMI(FMUState) snapshot,
                                        size_t *size) {
    (void)instance, (void)snapshot;
    *size = SNAPSHOT_SIZE;
    return FMI(OK);
}

FMI(Status) FMI(SerializeFMUState)(FMI(Instance) instance, FMI(FMUState) snapshot,
                                   FMI(Byte) bytes[], size_t size) {
    ALLOWED_IN(ANY)
    return (FMI(Status))serialize(it, snapshot, (unsigned char *)bytes, size);
}

FMI(Status) FMI(DeserializeFMUState)(FMI(Instance) instance, const FMI(Byte) bytes[], size_t size,
                                     FMI(FMUState) *snapshot) {
    State *state;
    ALLOWED_IN(ANY)
    state = new_memory(sizeof *state);
    if (!state) {
        return FAIL("out of memory");
    }
    if (deserialize(it, (const unsigned char *)bytes, size, state) != OK) {
        free_memory(state);
        return FMI(Error);
    }
    *snapshot = state;
    return FMI(OK);
}

/* sums[i]: the partial derivatives of unknown i by the knowns j, or (adjoint) of the unknowns j by
 * known i, each times seeds[j]. */
static FMI(Status) weigh_partials(Instance *it, int adjoint, const FMI(ValueReference) own[],
                                  size_t n, const FMI(ValueReference) others[], size_t n_others,
                                  const double seeds[], double sums[]) {
    size_t i, j;
    for (i = 0; i < n; i++) {
        sums[i] = 0.0;
        for (j = 0; j < n_others; j++) {
            size_t unknown = adjoint ? others[j] : own[i], known = adjoint ? own[i] : others[j];
            if (add_partials(it, unknown, known, seeds[j], sums + i) != OK) {
                return FMI(Error);
            }
        }
    }
    return FMI(OK);
}
