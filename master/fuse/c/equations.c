/* The system in the place of a model's equations. */

#include "equations.h"

#include "rules.h"
#include "system.h"

void apply_initial(Data *data) {
    data->memory.has_failed = !system_start(&data->memory, data->values, data->time);
}

void apply_outputs(Data *data) {
    if (!data->memory.has_failed) {
        system_publish(&data->memory, data->values);
    }
}

void remember_inputs(Data *data) {
    (void)data; /* each inner FMU remembers its own */
}

bool check_results(const Instance *instance, const Data *data) {
    return !data->memory.has_failed || refuse_text(instance, &data->memory.message);
}
