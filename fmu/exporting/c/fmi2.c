/* The functions of FMI 2.0 for Co-Simulation around an instance. */

#include "fmi2Functions.h"

/* What FMI 3.0 calls otherwise. */
#define FMI(name) fmi2##name
#define fmi2Instance fmi2Component
#define fmi2FMUState fmi2FMUstate
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate

static void tell(Instance *it, int status, const char *text) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)it->logger;
    if (logger) {
        logger(it->environment, it->name, (fmi2Status)status,
               status == OK ? "logEvents" : "logStatusError", text);
    }
}

#include "both.c"

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
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
    return finished(it, problem, logging);
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean tolerance_defined,
                               fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
                               fmi2Real stop) {
    ALLOWED_IN(1u << INSTANTIATED)
    (void)tolerance_defined, (void)tolerance;
    return (fmi2Status)set_times(it, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component instance) {
    ALLOWED_IN(1u << INSTANTIATED)
    it->now.phase = INITIALIZING;
    it->stale = 1;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component instance, const fmi2ValueReference references[], size_t n,
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

fmi2Status fmi2SetReal(fmi2Component instance, const fmi2ValueReference references[], size_t n,
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
    fmi2Status function(fmi2Component instance, const fmi2ValueReference references[], size_t n,   \
                        type values[]) {                                                           \
        ALLOWED_IN(ANY)                                                                            \
        (void)references, (void)values;                                                            \
        return n == 0 ? fmi2OK : FAIL("every variable is of type Real");                           \
    }

NONE_OF_TYPE(fmi2GetInteger, fmi2Integer)
NONE_OF_TYPE(fmi2GetBoolean, fmi2Boolean)
NONE_OF_TYPE(fmi2GetString, fmi2String)
NONE_OF_TYPE(fmi2SetInteger, const fmi2Integer)
NONE_OF_TYPE(fmi2SetBoolean, const fmi2Boolean)
NONE_OF_TYPE(fmi2SetString, const fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknowns[],
                                        size_t n_unknowns, const fmi2ValueReference knowns[],
                                        size_t n_knowns, const fmi2Real seeds[],
                                        fmi2Real sensitivities[]) {
    ALLOWED_IN(1u << INITIALIZING | RUNNING)
    return weigh_partials(it, 0, unknowns, n_unknowns, knowns, n_knowns, seeds, sensitivities);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component instance,
                                       const fmi2ValueReference references[], size_t n,
                                       const fmi2Integer orders[], const fmi2Real values[]) {
    ALLOWED_IN(ANY)
    (void)references, (void)orders, (void)values;
    return n == 0 ? fmi2OK : FAIL("inputs are held during a step");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component instance,
                                        const fmi2ValueReference references[], size_t n,
                                        const fmi2Integer orders[], fmi2Real values[]) {
    ALLOWED_IN(ANY)
    (void)references, (void)orders, (void)values;
    return n == 0 ? fmi2OK : FAIL("derivatives of outputs are not provided");
}

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
    ALLOWED_IN(RUNNING)
    (void)no_return;
    return (fmi2Status)take_step(it, time, step);
}

fmi2Status fmi2CancelStep(fmi2Component instance) {
    ALLOWED_IN(ANY)
    return FAIL("no step runs asynchronously");
}

fmi2Status fmi2GetRealStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Real *value) {
    ALLOWED_IN(ANY)
    if (kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = it->now.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component instance, const fmi2StatusKind kind,
                                fmi2Boolean *value) {
    ALLOWED_IN(ANY)
    if (kind != fmi2Terminated) {
        return fmi2Discard;
    }
    *value = it->now.phase == TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component instance, const fmi2StatusKind kind, fmi2Status *value) {
    (void)instance, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component instance, const fmi2StatusKind kind,
                                fmi2Integer *value) {
    (void)instance, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component instance, const fmi2StatusKind kind,
                               fmi2String *value) {
    (void)instance, (void)kind, (void)value;
    return fmi2Discard;
}
