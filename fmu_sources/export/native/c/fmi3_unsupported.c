/* FMI 3.0: what this FMU has not, with a message for whoever calls it. */

#include "fmi3Functions.h"

#include "instance.h"

static fmi3Status unsupported(const Instance *instance, const char *function) {
    if (instance != NULL) {
        refuse(instance, "%s: not supported, expected calls for co-simulation without events and clocks",
               function);
    }
    return fmi3Error;
}

#define UNSUPPORTED(FUNCTION, ...)                 \
    fmi3Status FUNCTION(fmi3Instance c, __VA_ARGS__) { \
        return unsupported(c, #FUNCTION);          \
    }

#define UNSUPPORTED_MODE(FUNCTION)         \
    fmi3Status FUNCTION(fmi3Instance c) {  \
        return unsupported(c, #FUNCTION);  \
    }

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef fmi3ValueReference Reference;

UNSUPPORTED_MODE(fmi3EnterEventMode)
UNSUPPORTED_MODE(fmi3EnterConfigurationMode)
UNSUPPORTED_MODE(fmi3ExitConfigurationMode)
UNSUPPORTED_MODE(fmi3EvaluateDiscreteStates)
UNSUPPORTED_MODE(fmi3EnterContinuousTimeMode)
UNSUPPORTED_MODE(fmi3EnterStepMode)

UNSUPPORTED(fmi3GetNumberOfVariableDependencies, Reference vr, size_t *n)
UNSUPPORTED(fmi3GetVariableDependencies, Reference vr, size_t elements[], Reference independents[],
            size_t independent_elements[], fmi3DependencyKind kinds[], size_t n)
UNSUPPORTED(fmi3GetAdjointDerivative, const Reference unknowns[], size_t n_unknowns, const Reference knowns[],
            size_t n_knowns, const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
            size_t n_sensitivity)

UNSUPPORTED(fmi3GetIntervalDecimal, const Reference vr[], size_t n, fmi3Float64 intervals[],
            fmi3IntervalQualifier qualifiers[])
UNSUPPORTED(fmi3GetIntervalFraction, const Reference vr[], size_t n, fmi3UInt64 counters[],
            fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
UNSUPPORTED(fmi3GetShiftDecimal, const Reference vr[], size_t n, fmi3Float64 shifts[])
UNSUPPORTED(fmi3GetShiftFraction, const Reference vr[], size_t n, fmi3UInt64 counters[],
            fmi3UInt64 resolutions[])
UNSUPPORTED(fmi3SetIntervalDecimal, const Reference vr[], size_t n, const fmi3Float64 intervals[])
UNSUPPORTED(fmi3SetIntervalFraction, const Reference vr[], size_t n, const fmi3UInt64 counters[],
            const fmi3UInt64 resolutions[])
UNSUPPORTED(fmi3SetShiftDecimal, const Reference vr[], size_t n, const fmi3Float64 shifts[])
UNSUPPORTED(fmi3SetShiftFraction, const Reference vr[], size_t n, const fmi3UInt64 counters[],
            const fmi3UInt64 resolutions[])
UNSUPPORTED(fmi3UpdateDiscreteStates, fmi3Boolean *needs_update, fmi3Boolean *wants_end,
            fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *has_next_event,
            fmi3Float64 *next_event)

UNSUPPORTED(fmi3CompletedIntegratorStep, fmi3Boolean never_goes_back, fmi3Boolean *enters_event_mode,
            fmi3Boolean *wants_end)
UNSUPPORTED(fmi3SetTime, fmi3Float64 time)
UNSUPPORTED(fmi3SetContinuousStates, const fmi3Float64 states[], size_t n)
UNSUPPORTED(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t n)
UNSUPPORTED(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t n)
UNSUPPORTED(fmi3GetContinuousStates, fmi3Float64 states[], size_t n)
UNSUPPORTED(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
UNSUPPORTED(fmi3GetNumberOfEventIndicators, size_t *n)
UNSUPPORTED(fmi3GetNumberOfContinuousStates, size_t *n)

UNSUPPORTED(fmi3GetOutputDerivatives, const Reference vr[], size_t n, const fmi3Int32 orders[],
            fmi3Float64 values[], size_t n_values)
UNSUPPORTED(fmi3ActivateModelPartition, Reference clock, fmi3Float64 activation_time)
