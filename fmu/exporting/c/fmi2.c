/* The functions of FMI 2.0 for Co-Simulation around an instance. */

#include "fmi2Functions.h"

static void tell(Instance *it, int status, const char *text) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)it->logger;
    if (logger) {
        logger(it->environment, it->name, (fmi2Status)status,
               status == OK ? "logEvents" : "logStatusError", text);
    }
}

#define BEFORE (1u << INSTANTIATED | 1u << INITIALIZING)
#define RUNNING (1u << STEPPING)
#define ANY (BEFORE | RUNNING | 1u << TERMINATED)
#define ALLOWED_IN(phases)                                                                         \
    Instance *it = c;                                                                              \
    if (!in_phase(it, __func__, phases)) {                                                         \
        return fmi2Error;                                                                          \
    }

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                               const fmi2String categories[]) {
    size_t i;
    int events = n == 0;
    ALLOWED_IN(ANY)
    for (i = 0; i < n; i++) {
        if (same_text(categories[i], "logEvents")) {
            events = 1;
        } else if (!same_text(categories[i], "logStatusError")) {
            return (fmi2Status)fail(it, "unknown log category");
        }
    }
    it->events = on && events;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    Instance *it = new_memory(sizeof *it);
    size_t i;
    const char *problem = NULL;
    (void)resources, (void)visible;
    if (!it) {
        return NULL;
    }
    for (i = 0; name && name[i] && i + 1 < sizeof it->name; i++) {
        it->name[i] = name[i];
    }
    if (functions) {
        it->logger = (void (*)(void))functions->logger;
        it->environment = functions->componentEnvironment;
    }
    if (!it->name[0]) {
        problem = "the instance needs a name";
    } else if (type != fmi2CoSimulation) {
        problem = "only co-simulation is provided";
    } else if (!guid || !same_text(guid, TOKEN)) {
        problem = "the GUID is not that of this FMU: modelDescription.xml and binary do not "
                  "belong together";
    }
    if (problem) {
        fail(it, problem);
        free_memory(it);
        return NULL;
    }
    reset(it);
    it->events = logging;
    return it;
}

void fmi2FreeInstance(fmi2Component c) {
    free_memory(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    ALLOWED_IN(1u << INSTANTIATED)
    (void)tolerance_defined, (void)tolerance;
    return (fmi2Status)set_times(it, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ALLOWED_IN(1u << INSTANTIATED)
    it->now.phase = INITIALIZING;
    it->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    ALLOWED_IN(1u << INITIALIZING)
    return (fmi2Status)finish_initialization(it);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    ALLOWED_IN(RUNNING)
    refresh(it);
    it->now.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    ALLOWED_IN(ANY)
    reset(it);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                       fmi2Real values[]) {
    size_t i;
    ALLOWED_IN(ANY)
    for (i = 0; i < n; i++) {
        if (get_value(it, references[i], values + i) != OK) {
            return fmi2Error;
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t n,
                       const fmi2Real values[]) {
    size_t i;
    ALLOWED_IN(BEFORE | RUNNING)
    for (i = 0; i < n; i++) {
        if (set_value(it, references[i], values[i]) != OK) {
            return fmi2Error;
        }
    }
    return fmi2OK;
}

/* Every variable is a real number. */
#define NONE_OF_TYPE(function, type)                                                               \
    fmi2Status function(fmi2Component c, const fmi2ValueReference references[], size_t n,          \
                        type values[]) {                                                           \
        ALLOWED_IN(ANY)                                                                            \
        (void)references, (void)values;                                                            \
        return n == 0 ? fmi2OK : (fmi2Status)fail(it, "every variable is of type Real");           \
    }

NONE_OF_TYPE(fmi2GetInteger, fmi2Integer)
NONE_OF_TYPE(fmi2GetBoolean, fmi2Boolean)
NONE_OF_TYPE(fmi2GetString, fmi2String)
NONE_OF_TYPE(fmi2SetInteger, const fmi2Integer)
NONE_OF_TYPE(fmi2SetBoolean, const fmi2Boolean)
NONE_OF_TYPE(fmi2SetString, const fmi2String)

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *snapshot) {
    ALLOWED_IN(ANY)
    if (!*snapshot) {
        *snapshot = new_memory(sizeof(State));
    }
    if (!*snapshot) {
        return (fmi2Status)fail(it, "out of memory");
    }
    *(State *)*snapshot = it->now;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate snapshot) {
    ALLOWED_IN(ANY)
    if (!snapshot) {
        return (fmi2Status)fail(it, "no state given");
    }
    restore(it, snapshot);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *snapshot) {
    (void)c;
    if (snapshot) {
        free_memory(*snapshot);
        *snapshot = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate snapshot, size_t *size) {
    (void)c, (void)snapshot;
    *size = SNAPSHOT_SIZE;
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate snapshot, fmi2Byte bytes[],
                                 size_t size) {
    ALLOWED_IN(ANY)
    return (fmi2Status)serialize(it, snapshot, (unsigned char *)bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *snapshot) {
    State *state;
    ALLOWED_IN(ANY)
    state = new_memory(sizeof *state);
    if (!state) {
        return (fmi2Status)fail(it, "out of memory");
    }
    if (deserialize(it, (const unsigned char *)bytes, size, state) != OK) {
        free_memory(state);
        return fmi2Error;
    }
    *snapshot = state;
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t n_unknowns, const fmi2ValueReference knowns[],
                                        size_t n_knowns, const fmi2Real seeds[],
                                        fmi2Real sensitivities[]) {
    size_t i, j;
    ALLOWED_IN(1u << INITIALIZING | RUNNING)
    for (i = 0; i < n_unknowns; i++) {
        sensitivities[i] = 0.0;
        for (j = 0; j < n_knowns; j++) {
            if (add_partials(it, unknowns[i], knowns[j], seeds[j], sensitivities + i) != OK) {
                return fmi2Error;
            }
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                       size_t n, const fmi2Integer orders[],
                                       const fmi2Real values[]) {
    ALLOWED_IN(ANY)
    (void)references, (void)orders, (void)values;
    return n == 0 ? fmi2OK : (fmi2Status)fail(it, "inputs are held during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                        size_t n, const fmi2Integer orders[], fmi2Real values[]) {
    ALLOWED_IN(ANY)
    (void)references, (void)orders, (void)values;
    return n == 0 ? fmi2OK : (fmi2Status)fail(it, "derivatives of outputs are not provided");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    ALLOWED_IN(RUNNING)
    (void)no_return;
    return (fmi2Status)take_step(it, time, step);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    ALLOWED_IN(ANY)
    return (fmi2Status)fail(it, "no step runs asynchronously");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    ALLOWED_IN(ANY)
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = it->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    ALLOWED_IN(ANY)
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = it->now.phase == TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
