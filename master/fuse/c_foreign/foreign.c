#include "foreign.h"

#if !defined(__linux__)
#error "FMUs of other tools are loaded on Linux alone"
#endif

#include <dlfcn.h>
#include <fenv.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

enum { MOST_AT_ONCE = 256, MOST_RETURNS = 1000000 };

typedef void Function(void);

typedef enum {
    INSTANTIATE,
    FREE_INSTANCE,
    SETUP_EXPERIMENT, /* of FMI 2.0 */
    ENTER_INITIALIZATION,
    EXIT_INITIALIZATION,
    TERMINATE,
    RESET,
    DO_STEP,
    GET_STATE,
    SET_STATE,
    FREE_STATE,
    N_FUNCTIONS
} FunctionName;

static const char *const NAMES_2[] = {
    "fmi2Instantiate", "fmi2FreeInstance", "fmi2SetupExperiment", "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2Reset", "fmi2DoStep", "fmi2GetFMUstate", "fmi2SetFMUstate",
    "fmi2FreeFMUstate"};
static const char *const NAMES_3[] = {
    "fmi3InstantiateCoSimulation", "fmi3FreeInstance", NULL, "fmi3EnterInitializationMode",
    "fmi3ExitInitializationMode", "fmi3Terminate", "fmi3Reset", "fmi3DoStep", "fmi3GetFMUState", "fmi3SetFMUState",
    "fmi3FreeFMUState"};
static const char *const TYPES_2[N_VALUE_TYPES] = {[VALUE_FLOAT64] = "Real",
                                                   [VALUE_INT32] = "Integer",
                                                   [VALUE_INT_BOOLEAN] = "Boolean",
                                                   [VALUE_STRING] = "String"};
static const char *const TYPES_3[N_VALUE_TYPES] = {
    [VALUE_FLOAT64] = "Float64", [VALUE_FLOAT32] = "Float32", [VALUE_INT8] = "Int8",     [VALUE_UINT8] = "UInt8",
    [VALUE_INT16] = "Int16",     [VALUE_UINT16] = "UInt16",   [VALUE_INT32] = "Int32",   [VALUE_UINT32] = "UInt32",
    [VALUE_INT64] = "Int64",     [VALUE_UINT64] = "UInt64",   [VALUE_BOOLEAN] = "Boolean", [VALUE_STRING] = "String"};
static const char *const STATUSES[] = {"OK", "warning", "discard", "error", "fatal", "pending"};

struct Foreign {
    const ForeignFmu *fmu;
    char *resources; /* as its own FMI names them */
    void *library;
    void *component;
    bool is_new; /* no call since instantiation */
    bool is_initialised;
    bool has_failed;
    bool is_lost; /* a fatal status: no more calls */
    void *state;  /* that was saved last */
    double *sent; /* by places: what the importer set last */
    int n_kept;   /* states that the importer keeps */
    fmi2CallbackFunctions callbacks;
    Function *functions[N_FUNCTIONS];
    Function *setters[N_VALUE_TYPES];
    Function *getters[N_VALUE_TYPES];
    Text heard; /* what the FMU said in the present call */
    Text said;
};

struct ForeignState {
    Foreign *foreign;
    void *state;
    double *sent;
    bool is_new;
    bool is_initialised;
    bool has_failed;
};

static const char *name_of(const Foreign *foreign, FunctionName function) {
    return foreign->fmu->version == 2 ? NAMES_2[function] : NAMES_3[function];
}

const char *foreign_name(const Foreign *foreign) {
    return foreign->fmu->name;
}

const char *foreign_said(const Foreign *foreign) {
    return foreign->said.at;
}

/* Only what an FMU says is wrong. */
static void hear(Foreign *foreign, int status, const char *text) {
    if (status > 1 && text != NULL) {
        text_append(&foreign->heard, "%s%s", foreign->heard.length > 0 ? "; " : "", text);
    }
}

static void log_2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                  fmi2String format, ...) {
    char text[1024] = "";
    va_list arguments;
    (void)name, (void)category;
    va_start(arguments, format);
    if (format != NULL) {
        vsnprintf(text, sizeof text, format, arguments);
    }
    va_end(arguments);
    hear(environment, status, text);
}

static void log_3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)category;
    hear(environment, (int)status, text);
}

static bool fail(Foreign *foreign, const char *what) {
    const Text heard = foreign->heard;
    foreign->has_failed = true;
    foreign->said.length = 0;
    text_append(&foreign->said, heard.length > 0 ? "%s (%s)" : "%s%s", heard.length > 0 ? heard.at : "", what);
    return false;
}

/* Whether a call went well: OK or with a warning. */
static bool went_well(Foreign *foreign, const char *function, int status) {
    char what[128];
    if (status == 0 || status == 1) {
        foreign->heard.length = 0;
        foreign->heard.at[0] = '\0';
        return true;
    }
    foreign->is_lost = foreign->is_lost || status == 4;
    if (status >= 0 && status <= 5) {
        snprintf(what, sizeof what, "%s answered with status %s", function, STATUSES[status]);
    } else {
        snprintf(what, sizeof what, "%s answered with status %d", function, status);
    }
    return fail(foreign, what);
}

/* Numbers */

static int set_typed(Foreign *foreign, ValueType type, const unsigned *references, size_t n, const double *values) {
    Function *const setter = foreign->setters[type];
    void *const c = foreign->component;
#define SET(code, name, c_type, expression)                                                                      \
    case code: {                                                                                                 \
        c_type typed[MOST_AT_ONCE];                                                                              \
        for (size_t i = 0; i < n; i++) {                                                                         \
            typed[i] = (c_type)(expression);                                                                     \
        }                                                                                                        \
        return (int)((fmi3Set##name##TYPE *)setter)(c, references, n, typed, n);                                 \
    }
    switch (type) {
    case VALUE_FLOAT64:
        if (foreign->fmu->version == 2) {
            return (int)((fmi2SetRealTYPE *)setter)(c, references, n, values);
        }
        return (int)((fmi3SetFloat64TYPE *)setter)(c, references, n, values, n);
    case VALUE_INT32: {
        int typed[MOST_AT_ONCE];
        for (size_t i = 0; i < n; i++) {
            typed[i] = (int)nearbyint(values[i]);
        }
        if (foreign->fmu->version == 2) {
            return (int)((fmi2SetIntegerTYPE *)setter)(c, references, n, typed);
        }
        return (int)((fmi3SetInt32TYPE *)setter)(c, references, n, typed, n);
    }
    case VALUE_INT_BOOLEAN: {
        fmi2Boolean typed[MOST_AT_ONCE];
        for (size_t i = 0; i < n; i++) {
            typed[i] = values[i] != 0.0;
        }
        return (int)((fmi2SetBooleanTYPE *)setter)(c, references, n, typed);
    }
        SET(VALUE_FLOAT32, Float32, float, values[i])
        SET(VALUE_INT8, Int8, int8_t, nearbyint(values[i]))
        SET(VALUE_UINT8, UInt8, uint8_t, nearbyint(values[i]))
        SET(VALUE_INT16, Int16, int16_t, nearbyint(values[i]))
        SET(VALUE_UINT16, UInt16, uint16_t, nearbyint(values[i]))
        SET(VALUE_UINT32, UInt32, uint32_t, nearbyint(values[i]))
        SET(VALUE_INT64, Int64, int64_t, nearbyint(values[i]))
        SET(VALUE_UINT64, UInt64, uint64_t, nearbyint(values[i]))
        SET(VALUE_BOOLEAN, Boolean, fmi3Boolean, values[i] != 0.0)
    default:
        return 3; /* texts are set by themselves */
    }
#undef SET
}

static int get_typed(Foreign *foreign, ValueType type, const unsigned *references, size_t n, double *values) {
    Function *const getter = foreign->getters[type];
    void *const c = foreign->component;
#define GET(code, name, c_type)                                                                                  \
    case code: {                                                                                                 \
        c_type typed[MOST_AT_ONCE];                                                                              \
        const int status = (int)((fmi3Get##name##TYPE *)getter)(c, references, n, typed, n);                     \
        for (size_t i = 0; i < n && (status == 0 || status == 1); i++) {                                         \
            values[i] = (double)typed[i];                                                                        \
        }                                                                                                        \
        return status;                                                                                           \
    }
    switch (type) {
    case VALUE_FLOAT64:
        if (foreign->fmu->version == 2) {
            return (int)((fmi2GetRealTYPE *)getter)(c, references, n, values);
        }
        return (int)((fmi3GetFloat64TYPE *)getter)(c, references, n, values, n);
    case VALUE_INT32:
    case VALUE_INT_BOOLEAN: {
        int typed[MOST_AT_ONCE];
        int status;
        if (type == VALUE_INT_BOOLEAN) {
            status = (int)((fmi2GetBooleanTYPE *)getter)(c, references, n, typed);
        } else if (foreign->fmu->version == 2) {
            status = (int)((fmi2GetIntegerTYPE *)getter)(c, references, n, typed);
        } else {
            status = (int)((fmi3GetInt32TYPE *)getter)(c, references, n, typed, n);
        }
        for (size_t i = 0; i < n && (status == 0 || status == 1); i++) {
            values[i] = type == VALUE_INT_BOOLEAN ? (double)(typed[i] != 0) : (double)typed[i];
        }
        return status;
    }
        GET(VALUE_FLOAT32, Float32, float)
        GET(VALUE_INT8, Int8, int8_t)
        GET(VALUE_UINT8, UInt8, uint8_t)
        GET(VALUE_INT16, Int16, int16_t)
        GET(VALUE_UINT16, UInt16, uint16_t)
        GET(VALUE_UINT32, UInt32, uint32_t)
        GET(VALUE_INT64, Int64, int64_t)
        GET(VALUE_UINT64, UInt64, uint64_t)
        GET(VALUE_BOOLEAN, Boolean, fmi3Boolean)
    default:
        return 3;
    }
#undef GET
}

static const char *type_name(const Foreign *foreign, ValueType type) {
    return foreign->fmu->version == 2 ? TYPES_2[type] : TYPES_3[type];
}

static bool exchanged(Foreign *foreign, const char *verb, ValueType type, int status) {
    char function[64];
    snprintf(function, sizeof function, "fmi%d%s%s", foreign->fmu->version, verb, type_name(foreign, type));
    return went_well(foreign, function, status);
}

/* Number of cells from one on that are of its type, as many as one call takes. */
static int alike(ForeignCells cells, int first) {
    int n = 1;
    while (first + n < cells.n && n < MOST_AT_ONCE && cells.at[first + n].type == cells.at[first].type) {
        n++;
    }
    return n;
}

/* Whether an integer type holds a value: of 64 bits, one of which a double has all digits. */
static bool fits(ValueType type, double value) {
    static const double least[N_VALUE_TYPES] = {
        [VALUE_INT8] = INT8_MIN, [VALUE_INT16] = INT16_MIN, [VALUE_INT32] = INT32_MIN, [VALUE_INT64] = -0x1p53 + 1.0};
    static const double largest[N_VALUE_TYPES] = {
        [VALUE_INT8] = INT8_MAX,   [VALUE_UINT8] = UINT8_MAX,     [VALUE_INT16] = INT16_MAX,
        [VALUE_UINT16] = UINT16_MAX, [VALUE_INT32] = INT32_MAX,   [VALUE_UINT32] = UINT32_MAX,
        [VALUE_INT64] = 0x1p53 - 1.0, [VALUE_UINT64] = 0x1p53 - 1.0};
    const double nearest = nearbyint(value);
    return largest[type] == 0.0 || (least[type] <= nearest && nearest <= largest[type]);
}

static bool refuse_misfit(Foreign *foreign, ValueType type, double value) {
    Text what = {.length = 0};
    text_append(&what, "value does not fit %s, got ", type_name(foreign, type));
    text_append_number(&what, value);
    return fail(foreign, what.at);
}

static bool set_cells(Foreign *foreign, ForeignCells cells, const double *values) {
    unsigned references[MOST_AT_ONCE];
    double some[MOST_AT_ONCE];
    for (int first = 0, n; first < cells.n; first += n) {
        const ValueType type = cells.at[first].type;
        n = alike(cells, first);
        for (int i = 0; i < n; i++) {
            references[i] = cells.at[first + i].reference;
            some[i] = values[cells.at[first + i].place];
            if (!fits(type, some[i])) {
                return refuse_misfit(foreign, type, some[i]);
            }
        }
        if (!exchanged(foreign, "Set", type, set_typed(foreign, type, references, (size_t)n, some))) {
            return false;
        }
    }
    return true;
}

static bool get_cells(Foreign *foreign, ForeignCells cells, double *values) {
    unsigned references[MOST_AT_ONCE];
    double some[MOST_AT_ONCE];
    for (int first = 0, n; first < cells.n; first += n) {
        const ValueType type = cells.at[first].type;
        n = alike(cells, first);
        for (int i = 0; i < n; i++) {
            references[i] = cells.at[first + i].reference;
        }
        if (!exchanged(foreign, "Get", type, get_typed(foreign, type, references, (size_t)n, some))) {
            return false;
        }
        for (int i = 0; i < n; i++) {
            values[cells.at[first + i].place] = some[i];
        }
    }
    return true;
}

static bool is_same(double one, double other) {
    return memcmp(&one, &other, sizeof one) == 0;
}

/* Number of places that the importer may set a value at, at least one. */
static int n_places(const ForeignFmu *fmu) {
    int n = 1;
    for (int i = 0; i < fmu->n_starts; i++) {
        n = fmu->starts[i].cell.place >= n ? fmu->starts[i].cell.place + 1 : n;
    }
    for (int i = 0; i < fmu->open.n; i++) {
        n = fmu->open.at[i].place >= n ? fmu->open.at[i].place + 1 : n;
    }
    return n;
}

/* What the importer has set since the last time. */
static bool set_open(Foreign *foreign, const double *values) {
    const ForeignCells open = foreign->fmu->open;
    for (int i = 0; i < open.n; i++) {
        const int place = open.at[i].place;
        if (!is_same(values[place], foreign->sent[place])) {
            if (!set_cells(foreign, (ForeignCells){&open.at[i], 1}, values)) {
                return false;
            }
            foreign->sent[place] = values[place];
        }
    }
    return true;
}

static bool set_text(Foreign *foreign, ForeignCell cell, const char *text) {
    Function *const setter = foreign->setters[VALUE_STRING];
    const int status =
        foreign->fmu->version == 2
            ? (int)((fmi2SetStringTYPE *)setter)(foreign->component, &cell.reference, 1, &text)
            : (int)((fmi3SetStringTYPE *)setter)(foreign->component, &cell.reference, 1, &text, 1);
    return exchanged(foreign, "Set", VALUE_STRING, status);
}

static bool set_starts(Foreign *foreign, const double *values) {
    for (int i = 0; i < foreign->fmu->n_starts; i++) {
        const ForeignStart *start = &foreign->fmu->starts[i];
        const bool is_of_importer = start->cell.place >= 0;
        const double value = is_of_importer ? values[start->cell.place] : start->value;
        const ForeignCell cell = {start->cell.reference, start->cell.type, 0};
        if (start->text != NULL) {
            if (!set_text(foreign, cell, start->text)) {
                return false;
            }
        } else if (start->is_given || !is_same(value, start->value)) {
            if (!set_cells(foreign, (ForeignCells){&cell, 1}, &value)) {
                return false;
            }
        }
        if (is_of_importer) {
            foreign->sent[start->cell.place] = value;
        }
    }
    return true;
}

/* Where it is */

/* Value of a hexadecimal digit, -1 if it is none. */
static int digit(char c) {
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *at = c == '\0' ? NULL : strchr(digits, c);
    return at == NULL ? -1 : (int)(at - digits) % 16;
}

/* Path of a folder that an importer names by a URI (FMI 2.0) or by a path (FMI 3.0), without a slash at its end. */
static char *path_of(const char *resources) {
    char *path = malloc(strlen(resources) + 1);
    size_t n = 0;
    const char *at = resources;
    const bool is_uri = strncmp(at, "file:", 5) == 0;
    if (path == NULL) {
        return NULL;
    }
    if (is_uri) {
        at += 5;
        if (strncmp(at, "//", 2) == 0) { /* a name of a host follows, as a rule none */
            at += 2;
            at += strcspn(at, "/");
        }
    }
    while (*at != '\0') {
        if (is_uri && *at == '%' && digit(at[1]) >= 0 && digit(at[2]) >= 0) {
            path[n++] = (char)(16 * digit(at[1]) + digit(at[2]));
            at += 3;
        } else {
            path[n++] = *at++;
        }
    }
    while (n > 1 && path[n - 1] == '/') {
        n--;
    }
    path[n] = '\0';
    return path;
}

static char *joined(const char *folder, const char *one, const char *other) {
    const size_t size = strlen(folder) + strlen(one) + strlen(other) + 3;
    char *path = malloc(size);
    if (path != NULL) {
        snprintf(path, size, "%s/%s/%s", folder, one, other);
    }
    return path;
}

static char *uri_of(const char *path) {
    static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
    char *uri = malloc(3 * strlen(path) + sizeof "file://");
    if (uri == NULL) {
        return NULL;
    }
    char *end = uri + sprintf(uri, "file://");
    for (const char *at = path; *at != '\0'; at++) {
        if (strchr(plain, *at) != NULL) {
            *end++ = *at;
        } else {
            end += sprintf(end, "%%%02X", (unsigned)(unsigned char)*at);
        }
    }
    *end = '\0';
    return uri;
}

/* Loading */

static Function *found(void *library, const char *name) {
    Function *function;
    void *const address = dlsym(library, name);
    memcpy(&function, &address, sizeof function); /* ISO C knows no conversion between the two */
    return function;
}

static bool find_functions(Foreign *foreign) {
    const ForeignFmu *fmu = foreign->fmu;
    char name[64];
    for (FunctionName i = 0; i < N_FUNCTIONS; i++) {
        const char *function = name_of(foreign, i);
        foreign->functions[i] = function == NULL ? NULL : found(foreign->library, function);
        const bool is_of_state = i == GET_STATE || i == SET_STATE || i == FREE_STATE;
        if (function != NULL && foreign->functions[i] == NULL && (fmu->saves_state || !is_of_state)) {
            snprintf(name, sizeof name, "%s is not in its library", function);
            return fail(foreign, name);
        }
    }
    for (ValueType i = 0; i < N_VALUE_TYPES; i++) {
        const char *type = type_name(foreign, i);
        if (type != NULL) {
            snprintf(name, sizeof name, "fmi%dSet%s", fmu->version, type);
            foreign->setters[i] = found(foreign->library, name);
            snprintf(name, sizeof name, "fmi%dGet%s", fmu->version, type);
            foreign->getters[i] = found(foreign->library, name);
            if (foreign->setters[i] == NULL || foreign->getters[i] == NULL) {
                snprintf(name, sizeof name, "no functions for %s in its library", type);
                return fail(foreign, name);
            }
        }
    }
    return true;
}

static bool instantiate(Foreign *foreign) {
    const ForeignFmu *fmu = foreign->fmu;
    Function *const function = foreign->functions[INSTANTIATE];
    foreign->component =
        fmu->version == 2
            ? ((fmi2InstantiateTYPE *)function)(fmu->name, fmi2CoSimulation, fmu->token, foreign->resources,
                                                &foreign->callbacks, fmi2False, fmi2True)
            : ((fmi3InstantiateCoSimulationTYPE *)function)(fmu->name, fmu->token, foreign->resources, false, true,
                                                            false, false, NULL, 0, foreign, log_3, NULL);
    foreign->is_new = true;
    foreign->is_initialised = false;
    foreign->has_failed = false;
    if (foreign->component == NULL) {
        char what[64];
        snprintf(what, sizeof what, "%s returned no instance", name_of(foreign, INSTANTIATE));
        return fail(foreign, what);
    }
    return true;
}

static void free_instance(Foreign *foreign) {
    if (foreign->component == NULL || foreign->is_lost) {
        return;
    }
    if (foreign->is_initialised && !foreign->has_failed) {
        ((fmi2TerminateTYPE *)foreign->functions[TERMINATE])(foreign->component);
    }
    if (foreign->state != NULL) {
        ((fmi2FreeFMUstateTYPE *)foreign->functions[FREE_STATE])(foreign->component, &foreign->state);
        foreign->state = NULL;
    }
    ((fmi2FreeInstanceTYPE *)foreign->functions[FREE_INSTANCE])(foreign->component);
    foreign->component = NULL;
}

static bool load(Foreign *foreign, const char *resources) {
    const ForeignFmu *fmu = foreign->fmu;
    if (resources == NULL) {
        return fail(foreign, "is in the resources of this FMU, got no location of them from the importer");
    }
    char *folder = path_of(resources);
    char *library = folder == NULL ? NULL : joined(folder, fmu->folder, fmu->library);
    char *own = folder == NULL ? NULL : joined(folder, fmu->folder, "resources/");
    foreign->resources = own;
    if (own != NULL && fmu->version == 2) {
        own[strlen(own) - 1] = '\0';
        foreign->resources = uri_of(own);
        free(own);
    }
    if (foreign->resources != NULL && library != NULL) {
        foreign->library = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    }
    free(folder);
    free(library);
    if (foreign->library == NULL) {
        const char *why = dlerror();
        Text what = {.length = 0};
        text_append(&what, "cannot be loaded: %s", why != NULL ? why : "out of memory");
        return fail(foreign, what.at);
    }
    return find_functions(foreign) && instantiate(foreign);
}

Foreign *foreign_open(const ForeignFmu *fmu, const char *resources, Text *message) {
    Foreign *foreign = calloc(1, sizeof *foreign);
    double *sent = calloc((size_t)n_places(fmu), sizeof *sent);
    if (foreign == NULL || sent == NULL) {
        free(foreign);
        free(sent);
        text_append(message, "%s: out of memory", fmu->name);
        return NULL;
    }
    foreign->fmu = fmu;
    foreign->sent = sent;
    const fmi2CallbackFunctions callbacks = {log_2, calloc, free, NULL, foreign};
    memcpy(&foreign->callbacks, &callbacks, sizeof callbacks); /* its members are const */
    fenv_t mode;
    fegetenv(&mode);
    const bool is_loaded = load(foreign, resources);
    fesetenv(&mode);
    if (!is_loaded) {
        text_append(message, "%s: %s", fmu->name, foreign->said.at);
        foreign_close(foreign);
        return NULL;
    }
    return foreign;
}

void foreign_close(Foreign *foreign) {
    if (foreign == NULL) {
        return;
    }
    free_instance(foreign);
    if (foreign->library != NULL && !foreign->is_lost) {
        dlclose(foreign->library);
    }
    free(foreign->resources);
    free(foreign->sent);
    free(foreign);
}

/* A run */

/* A function that takes the instance alone. */
static bool call(Foreign *foreign, FunctionName function) {
    const int status = (int)((fmi2ResetTYPE *)foreign->functions[function])(foreign->component);
    return went_well(foreign, name_of(foreign, function), status);
}

static bool renew(Foreign *foreign) {
    if (foreign->is_lost) {
        return fail(foreign, "no more calls after a fatal status");
    }
    if (foreign->is_new) {
        return true;
    }
    if ((foreign->fmu->is_alone || foreign->n_kept > 0) && foreign->component != NULL) {
        foreign->is_initialised = false;
        foreign->has_failed = false;
        return call(foreign, RESET);
    }
    free_instance(foreign);
    return instantiate(foreign);
}

static bool start(Foreign *foreign, const double *values, double t0) {
    if (!renew(foreign)) {
        return false;
    }
    foreign->is_new = false;
    if (!set_starts(foreign, values)) {
        return false;
    }
    if (foreign->fmu->version == 2) {
        const int status = (int)((fmi2SetupExperimentTYPE *)foreign->functions[SETUP_EXPERIMENT])(
            foreign->component, fmi2False, 0.0, t0, fmi2False, 0.0);
        return went_well(foreign, name_of(foreign, SETUP_EXPERIMENT), status) && call(foreign, ENTER_INITIALIZATION);
    }
    const int status = (int)((fmi3EnterInitializationModeTYPE *)foreign->functions[ENTER_INITIALIZATION])(
        foreign->component, false, 0.0, t0, false, 0.0);
    return went_well(foreign, name_of(foreign, ENTER_INITIALIZATION), status);
}

/* A step of FMI 3.0: after an early return, on to its end. */
static bool step_3(Foreign *foreign, double t, double h) {
    fmi3DoStepTYPE *const do_step = (fmi3DoStepTYPE *)foreign->functions[DO_STEP];
    const double end = t + h;
    const double tolerance = 1e-9 * h + 4e-16 * fabs(end);
    double reached = t;
    double length = h;
    for (int n = 0; n < MOST_RETURNS; n++) {
        bool wants_events = false, wants_end = false, is_early = false;
        double last = reached + length;
        const int status = (int)do_step(foreign->component, reached, length, true, &wants_events, &wants_end,
                                        &is_early, &last);
        if (!went_well(foreign, "fmi3DoStep", status)) {
            return false;
        }
        if (wants_events) {
            return fail(foreign, "asks for the event mode that it was not given");
        }
        if (wants_end) {
            return fail(foreign, "asks for the end of the simulation");
        }
        if (isnan(last)) {
            return fail(foreign, "fmi3DoStep returned a time that is not a number");
        }
        if (!is_early || last >= end - tolerance) {
            return true;
        }
        if (!(last > reached)) {
            return fail(foreign, "returned early from a step without getting on");
        }
        reached = last;
        length = end - reached;
    }
    return fail(foreign, "returned early from a step too often");
}

static bool step(Foreign *foreign, double *values, double t, double h) {
    if (!set_open(foreign, values) || !set_cells(foreign, foreign->fmu->received, values)) {
        return false;
    }
    if (foreign->fmu->version == 3) {
        return step_3(foreign, t, h) && get_cells(foreign, foreign->fmu->shown, values);
    }
    const int status = (int)((fmi2DoStepTYPE *)foreign->functions[DO_STEP])(foreign->component, t, h, fmi2True);
    return went_well(foreign, "fmi2DoStep", status) && get_cells(foreign, foreign->fmu->shown, values);
}

static bool save(Foreign *foreign, const double *values) {
    if (!set_open(foreign, values)) {
        return false;
    }
    const int status = (int)((fmi2GetFMUstateTYPE *)foreign->functions[GET_STATE])(foreign->component, &foreign->state);
    return went_well(foreign, name_of(foreign, GET_STATE), status);
}

static bool restore(Foreign *foreign) {
    const int status = (int)((fmi2SetFMUstateTYPE *)foreign->functions[SET_STATE])(foreign->component, foreign->state);
    return went_well(foreign, name_of(foreign, SET_STATE), status);
}

static bool keep(Foreign *foreign, ForeignState *kept) {
    const int status = (int)((fmi2GetFMUstateTYPE *)foreign->functions[GET_STATE])(foreign->component, &kept->state);
    if (!went_well(foreign, name_of(foreign, GET_STATE), status)) {
        return false;
    }
    memcpy(kept->sent, foreign->sent, (size_t)n_places(foreign->fmu) * sizeof *kept->sent);
    kept->is_new = foreign->is_new;
    kept->is_initialised = foreign->is_initialised;
    kept->has_failed = foreign->has_failed;
    return true;
}

static bool bring_back(Foreign *foreign, const ForeignState *kept) {
    if (foreign->is_lost) {
        return fail(foreign, "no more calls after a fatal status");
    }
    const int status = (int)((fmi2SetFMUstateTYPE *)foreign->functions[SET_STATE])(foreign->component, kept->state);
    if (!went_well(foreign, name_of(foreign, SET_STATE), status)) {
        return false;
    }
    memcpy(foreign->sent, kept->sent, (size_t)n_places(foreign->fmu) * sizeof *kept->sent);
    foreign->is_new = kept->is_new;
    foreign->is_initialised = kept->is_initialised;
    foreign->has_failed = kept->has_failed;
    return true;
}

static bool begin(Foreign *foreign, double *values) {
    if (!call(foreign, EXIT_INITIALIZATION)) {
        return false;
    }
    foreign->is_initialised = true;
    return get_cells(foreign, foreign->fmu->shown, values);
}

/* An FMU that leaves another floating-point mode would change the bits of all others. */
#define IN_OUR_MODE(expression)                                                                                  \
    do {                                                                                                         \
        fenv_t mode;                                                                                             \
        fegetenv(&mode);                                                                                         \
        const bool is_well = (expression);                                                                       \
        fesetenv(&mode);                                                                                         \
        return is_well;                                                                                          \
    } while (0)

bool foreign_start(Foreign *foreign, const double *values, double t0) {
    IN_OUR_MODE(start(foreign, values, t0));
}

bool foreign_set(Foreign *foreign, ForeignCell cell, const double *values) {
    IN_OUR_MODE(set_cells(foreign, (ForeignCells){&cell, 1}, values));
}

bool foreign_read_sources(Foreign *foreign, double *values) {
    IN_OUR_MODE(get_cells(foreign, foreign->fmu->sources, values));
}

bool foreign_begin(Foreign *foreign, double *values) {
    IN_OUR_MODE(begin(foreign, values));
}

bool foreign_step(Foreign *foreign, double *values, double t, double h) {
    IN_OUR_MODE(step(foreign, values, t, h));
}

bool foreign_save(Foreign *foreign, const double *values) {
    IN_OUR_MODE(save(foreign, values));
}

bool foreign_restore(Foreign *foreign) {
    IN_OUR_MODE(restore(foreign));
}

bool foreign_keep(Foreign *foreign, ForeignState **kept) {
    if (foreign->is_lost) {
        return fail(foreign, "no more calls after a fatal status");
    }
    if (*kept == NULL) {
        ForeignState *const made = calloc(1, sizeof *made);
        double *const sent = calloc((size_t)n_places(foreign->fmu), sizeof *sent);
        if (made == NULL || sent == NULL) {
            free(made);
            free(sent);
            return fail(foreign, "out of memory");
        }
        made->foreign = foreign;
        made->sent = sent;
        foreign->n_kept++;
        *kept = made;
    }
    IN_OUR_MODE(keep(foreign, *kept));
}

bool foreign_bring_back(Foreign *foreign, const ForeignState *kept) {
    IN_OUR_MODE(bring_back(foreign, kept));
}

void foreign_forget(ForeignState **kept) {
    ForeignState *const own = *kept;
    if (own == NULL) {
        return;
    }
    Foreign *const foreign = own->foreign;
    if (own->state != NULL && !foreign->is_lost) {
        fenv_t mode;
        fegetenv(&mode);
        ((fmi2FreeFMUstateTYPE *)foreign->functions[FREE_STATE])(foreign->component, &own->state);
        fesetenv(&mode);
    }
    foreign->n_kept--;
    free(own->sent);
    free(own);
    *kept = NULL;
}
