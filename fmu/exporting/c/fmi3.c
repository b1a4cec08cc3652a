/* The functions of FMI 3.0 for Co-Simulation around an instance. */

#include "fmi3Functions.h"

#define FMI(name) fmi3##name

static void tell(Instance *it, int status, const char *text) {
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)it->logger;
    if (logger) {
        logger(it->environment, (fmi3Status)status, status == OK ? "logEvents" : "logStatusError",
               text);
    }
}

#include "both.c"

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
    const fmi3ValueReference intermediate[], size_t n_intermediate,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3IntermediateUpdateCallback update) {
    Instance *it = new_memory(sizeof *it);
    const char *problem = NULL;
    (void)resources, (void)visible, (void)early_return, (void)intermediate, (void)update;
    if (!it) {
        return NULL;
    }
    it->logger = (void (*)(void))logger;
    it->environment = environment;
    if (!name || !name[0]) {
        problem = "the instance needs a name";
    } else if (!token || !same_text(token, TOKEN)) {
        problem = "the instantiation token is not that of this FMU: modelDescription.xml and "
                  "binary do not belong together";
    } else if (event_mode) {
        problem = "there is no event mode";
    } else if (n_intermediate) {
        problem = "there are no intermediate updates";
    }
    return finished(it, problem, logging);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    if (logger) {
        logger(environment, fmi3Error, "logStatusError", "only co-simulation is provided");
    }
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock) {
    (void)update, (void)lock, (void)unlock;
    return fmi3InstantiateModelExchange(name, token, resources, visible, logging, environment,
                                        logger);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop) {
    ALLOWED_IN(1u << INSTANTIATED)
    (void)tolerance_defined, (void)tolerance;
    if (set_times(it, start, stop_defined, stop) != OK) {
        return fmi3Error;
    }
    it->now.phase = INITIALIZING;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                          fmi3Float64 values[], size_t n_values) {
    size_t i;
    ALLOWED_IN(ANY)
    if (n != n_values) {
        return FAIL("every variable is a scalar: as many values as references");
    }
    for (i = 0; i < n; i++) {
        if (references[i] == 0) {
            values[i] = it->now.time;
        } else if (get_value(it, references[i], values + i) != OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t n,
                          const fmi3Float64 values[], size_t n_values) {
    size_t i;
    ALLOWED_IN(BEFORE | RUNNING)
    if (n != n_values) {
        return FAIL("every variable is a scalar: as many values as references");
    }
    for (i = 0; i < n; i++) {
        if (set_value(it, references[i], values[i]) != OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

/* Every variable is a Float64. */
#define NONE_OF_TYPE(name, type)                                                                   \
    fmi3Status fmi3Get##name(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t n, type values[], size_t n_values) {                           \
        ALLOWED_IN(ANY)                                                                            \
        (void)references, (void)values, (void)n_values;                                            \
        return n == 0 ? fmi3OK : FAIL("every variable is of type Float64");                        \
    }                                                                                              \
    fmi3Status fmi3Set##name(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t n, const type values[], size_t n_values) {                     \
        ALLOWED_IN(ANY)                                                                            \
        (void)references, (void)values, (void)n_values;                                            \
        return n == 0 ? fmi3OK : FAIL("every variable is of type Float64");                        \
    }

NONE_OF_TYPE(Float32, fmi3Float32)
NONE_OF_TYPE(Int8, fmi3Int8)
NONE_OF_TYPE(UInt8, fmi3UInt8)
NONE_OF_TYPE(Int16, fmi3Int16)
NONE_OF_TYPE(UInt16, fmi3UInt16)
NONE_OF_TYPE(Int32, fmi3Int32)
NONE_OF_TYPE(UInt32, fmi3UInt32)
NONE_OF_TYPE(Int64, fmi3Int64)
NONE_OF_TYPE(UInt64, fmi3UInt64)
NONE_OF_TYPE(Boolean, fmi3Boolean)
NONE_OF_TYPE(String, fmi3String)

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t n_unknowns, const fmi3ValueReference knowns[],
                                        size_t n_knowns, const fmi3Float64 seeds[], size_t n_seeds,
                                        fmi3Float64 sensitivities[], size_t n_sensitivities) {
    ALLOWED_IN(1u << INITIALIZING | RUNNING)
    if (n_seeds != n_knowns || n_sensitivities != n_unknowns) {
        return FAIL("expected a seed for each known, a sensitivity for each unknown");
    }
    return weigh_partials(it, 0, unknowns, n_unknowns, knowns, n_knowns, seeds, sensitivities);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t n_unknowns, const fmi3ValueReference knowns[],
                                    size_t n_knowns, const fmi3Float64 seeds[], size_t n_seeds,
                                    fmi3Float64 sensitivities[], size_t n_sensitivities) {
    ALLOWED_IN(1u << INITIALIZING | RUNNING)
    if (n_seeds != n_unknowns || n_sensitivities != n_knowns) {
        return FAIL("expected a seed for each unknown, a sensitivity for each known");
    }
    return weigh_partials(it, 1, knowns, n_knowns, unknowns, n_unknowns, seeds, sensitivities);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step,
                      fmi3Boolean no_return, fmi3Boolean *event_needed, fmi3Boolean *terminate,
                      fmi3Boolean *early_return, fmi3Float64 *last_time) {
    fmi3Status status;
    ALLOWED_IN(RUNNING)
    (void)no_return;
    status = (fmi3Status)take_step(it, time, step);
    *event_needed = *terminate = *early_return = fmi3False;
    *last_time = it->now.time;
    return status;
}

#include "fmi3_absent.c"
