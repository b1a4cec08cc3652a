/* The functions of FMI 3.0 that a block has no use for: they say so. */

#define NOT_PROVIDED(function, parameters)                                                         \
    fmi3Status function parameters {                                                               \
        Instance *it = instance;                                                                   \
        return it ? (fmi3Status)fail(it, #function " is not provided") : fmi3Error;                \
    }

#define REFERENCES const fmi3ValueReference references[], size_t n

/* Every parameter of what is not provided goes unused. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

NOT_PROVIDED(fmi3GetBinary, (fmi3Instance instance, REFERENCES, size_t sizes[],
                             fmi3Binary values[], size_t n_values))
NOT_PROVIDED(fmi3SetBinary, (fmi3Instance instance, REFERENCES, const size_t sizes[],
                             const fmi3Binary values[], size_t n_values))
NOT_PROVIDED(fmi3GetClock, (fmi3Instance instance, REFERENCES, fmi3Clock values[]))
NOT_PROVIDED(fmi3SetClock, (fmi3Instance instance, REFERENCES, const fmi3Clock values[]))
NOT_PROVIDED(fmi3GetNumberOfVariableDependencies,
             (fmi3Instance instance, fmi3ValueReference reference, size_t *n))
NOT_PROVIDED(fmi3GetVariableDependencies,
             (fmi3Instance instance, fmi3ValueReference dependent, size_t dependent_elements[],
              fmi3ValueReference independents[], size_t independent_elements[],
              fmi3DependencyKind kinds[], size_t n))
NOT_PROVIDED(fmi3EnterConfigurationMode, (fmi3Instance instance))
NOT_PROVIDED(fmi3ExitConfigurationMode, (fmi3Instance instance))
NOT_PROVIDED(fmi3EnterEventMode, (fmi3Instance instance))
NOT_PROVIDED(fmi3EnterStepMode, (fmi3Instance instance))
NOT_PROVIDED(fmi3GetIntervalDecimal, (fmi3Instance instance, REFERENCES, fmi3Float64 intervals[],
                                      fmi3IntervalQualifier qualifiers[]))
NOT_PROVIDED(fmi3GetIntervalFraction,
             (fmi3Instance instance, REFERENCES, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
              fmi3IntervalQualifier qualifiers[]))
NOT_PROVIDED(fmi3GetShiftDecimal, (fmi3Instance instance, REFERENCES, fmi3Float64 shifts[]))
NOT_PROVIDED(fmi3GetShiftFraction, (fmi3Instance instance, REFERENCES, fmi3UInt64 counters[],
                                    fmi3UInt64 resolutions[]))
NOT_PROVIDED(fmi3SetIntervalDecimal,
             (fmi3Instance instance, REFERENCES, const fmi3Float64 intervals[]))
NOT_PROVIDED(fmi3SetIntervalFraction, (fmi3Instance instance, REFERENCES,
                                       const fmi3UInt64 counters[], const fmi3UInt64 resolutions[]))
NOT_PROVIDED(fmi3SetShiftDecimal, (fmi3Instance instance, REFERENCES, const fmi3Float64 shifts[]))
NOT_PROVIDED(fmi3SetShiftFraction, (fmi3Instance instance, REFERENCES, const fmi3UInt64 counters[],
                                    const fmi3UInt64 resolutions[]))
NOT_PROVIDED(fmi3EvaluateDiscreteStates, (fmi3Instance instance))
NOT_PROVIDED(fmi3UpdateDiscreteStates,
             (fmi3Instance instance, fmi3Boolean *need_update, fmi3Boolean *terminate,
              fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
              fmi3Boolean *next_time_defined, fmi3Float64 *next_time))
NOT_PROVIDED(fmi3EnterContinuousTimeMode, (fmi3Instance instance))
NOT_PROVIDED(fmi3CompletedIntegratorStep,
             (fmi3Instance instance, fmi3Boolean no_return, fmi3Boolean *event_mode,
              fmi3Boolean *terminate))
NOT_PROVIDED(fmi3SetTime, (fmi3Instance instance, fmi3Float64 time))
NOT_PROVIDED(fmi3SetContinuousStates,
             (fmi3Instance instance, const fmi3Float64 x[], size_t n))
NOT_PROVIDED(fmi3GetContinuousStateDerivatives,
             (fmi3Instance instance, fmi3Float64 derivatives[], size_t n))
NOT_PROVIDED(fmi3GetEventIndicators, (fmi3Instance instance, fmi3Float64 indicators[], size_t n))
NOT_PROVIDED(fmi3GetContinuousStates, (fmi3Instance instance, fmi3Float64 x[], size_t n))
NOT_PROVIDED(fmi3GetNominalsOfContinuousStates,
             (fmi3Instance instance, fmi3Float64 nominals[], size_t n))
NOT_PROVIDED(fmi3GetNumberOfEventIndicators, (fmi3Instance instance, size_t *n))
NOT_PROVIDED(fmi3GetNumberOfContinuousStates, (fmi3Instance instance, size_t *n))
NOT_PROVIDED(fmi3GetOutputDerivatives, (fmi3Instance instance, REFERENCES, const fmi3Int32 orders[],
                                        fmi3Float64 values[], size_t n_values))
NOT_PROVIDED(fmi3ActivateModelPartition,
             (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time))
