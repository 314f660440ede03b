/* A plain host: loads the library of an FMU, runs an experiment that stands in a text file, prints the outputs.

   host VERSION LIBRARY TOKEN EXPERIMENT [RESOURCES, as the version of FMI names them]
   experiment: n_set n_inputs n_outputs n_rows step
               r|i|b REFERENCE VALUE               (n_set lines: real, integer or enumeration, Boolean)
               references of the inputs, of the outputs
               the inputs of each row */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static HMODULE library;
static void open_library(const char *path) { library = LoadLibraryA(path); }
static void *symbol(const char *name) { return (void *)GetProcAddress(library, name); }
#else
#include <dlfcn.h>
static void *library;
static void open_library(const char *path) { library = dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *symbol(const char *name) { return dlsym(library, name); }
#endif

enum { MOST = 64 };

static void *component;
static FILE *experiment;

static void fail(const char *what) {
    fprintf(stderr, "host: %s failed\n", what);
    exit(1);
}

#define OK(call)       \
    do {               \
        if ((call))    \
            fail(#call); \
    } while (0)
#define GET(name) name##TYPE *name = (name##TYPE *)symbol(#name)
#define READ(...)                                  \
    do {                                           \
        if (fscanf(experiment, __VA_ARGS__) < 1)   \
            fail("reading the experiment");        \
    } while (0)

static void log2_(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String text, ...) {
    (void)e, (void)n, (void)s, (void)c;
    fprintf(stderr, "%s\n", text);
}

static void log3(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String text) {
    (void)e, (void)s, (void)c;
    fprintf(stderr, "%s\n", text);
}

static const fmi2CallbackFunctions callbacks = {log2_, calloc, free, NULL, NULL};

static void instantiate(int version, const char *token, const char *resources) {
    GET(fmi2Instantiate);
    GET(fmi3InstantiateCoSimulation);
    if (version == 2)
        component = fmi2Instantiate("host", fmi2CoSimulation, token, resources ? resources : "", &callbacks,
                                    fmi2False, fmi2False);
    else
        component = fmi3InstantiateCoSimulation("host", token, resources, false, false, false, false, NULL, 0, NULL,
                                                log3, NULL);
    if (!component)
        fail("instantiation");
}

static void set_parameter(int version, char kind, unsigned reference, double value) {
    GET(fmi2SetReal);
    GET(fmi2SetInteger);
    GET(fmi2SetBoolean);
    GET(fmi3SetFloat64);
    GET(fmi3SetInt64);
    GET(fmi3SetInt32);
    GET(fmi3SetBoolean);
    int whole = (int)value;
    int64_t item = whole;
    bool flag = whole != 0;
    if (kind == 'r')
        OK(version == 2 ? fmi2SetReal(component, &reference, 1, &value)
                        : fmi3SetFloat64(component, &reference, 1, &value, 1));
    else if (kind == 'b')
        OK(version == 2 ? fmi2SetBoolean(component, &reference, 1, &whole)
                        : fmi3SetBoolean(component, &reference, 1, &flag, 1));
    else if (kind == 'e')
        OK(version == 2 ? fmi2SetInteger(component, &reference, 1, &whole)
                        : fmi3SetInt64(component, &reference, 1, &item, 1));
    else
        OK(version == 2 ? fmi2SetInteger(component, &reference, 1, &whole)
                        : fmi3SetInt32(component, &reference, 1, &whole, 1));
}

static void initialise(int version, int enter) {
    GET(fmi2SetupExperiment);
    GET(fmi2EnterInitializationMode);
    GET(fmi2ExitInitializationMode);
    GET(fmi3EnterInitializationMode);
    GET(fmi3ExitInitializationMode);
    if (!enter)
        OK(version == 2 ? fmi2ExitInitializationMode(component) : fmi3ExitInitializationMode(component));
    else if (version == 3)
        OK(fmi3EnterInitializationMode(component, false, 0.0, 0.0, false, 0.0));
    else {
        OK(fmi2SetupExperiment(component, fmi2False, 0.0, 0.0, fmi2False, 0.0));
        OK(fmi2EnterInitializationMode(component));
    }
}

static void set_inputs(int version, const unsigned *references, size_t n, const double *values) {
    GET(fmi2SetReal);
    GET(fmi3SetFloat64);
    OK(version == 2 ? fmi2SetReal(component, references, n, values)
                    : fmi3SetFloat64(component, references, n, values, n));
}

static void print_outputs(int version, const unsigned *references, size_t n) {
    double values[MOST];
    GET(fmi2GetReal);
    GET(fmi3GetFloat64);
    OK(version == 2 ? fmi2GetReal(component, references, n, values)
                    : fmi3GetFloat64(component, references, n, values, n));
    for (size_t i = 0; i < n; i++)
        printf("%.17g%c", values[i], i + 1 < n ? ',' : '\n');
}

static void step(int version, double t, double h) {
    GET(fmi2DoStep);
    GET(fmi3DoStep);
    bool event, end, early;
    double last;
    OK(version == 2 ? fmi2DoStep(component, t, h, fmi2True)
                    : fmi3DoStep(component, t, h, true, &event, &end, &early, &last));
}

static void read_row(double *values, size_t n) {
    for (size_t i = 0; i < n; i++)
        READ("%lf", &values[i]);
}

static void run(int version) {
    unsigned n_set, n_inputs, n_outputs, n_rows, inputs[MOST], outputs[MOST];
    double h, row[MOST];
    READ("%u %u %u %u %lf", &n_set, &n_inputs, &n_outputs, &n_rows, &h);
    for (unsigned i = 0; i < n_set; i++) {
        char kind;
        unsigned reference;
        double value;
        READ(" %c %u %lf", &kind, &reference, &value);
        set_parameter(version, kind, reference, value);
    }
    for (unsigned i = 0; i < n_inputs; i++)
        READ("%u", &inputs[i]);
    for (unsigned i = 0; i < n_outputs; i++)
        READ("%u", &outputs[i]);
    initialise(version, 1);
    for (unsigned k = 0; k < n_rows; k++) {
        read_row(row, n_inputs);
        set_inputs(version, inputs, n_inputs, row);
        if (k == 0) {
            initialise(version, 0);
            print_outputs(version, outputs, n_outputs);
        }
        if (k + 1 < n_rows) {
            step(version, k * h, h);
            print_outputs(version, outputs, n_outputs);
        }
    }
}

int main(int argc, char **argv) {
    if (argc != 5 && argc != 6)
        fail("reading the arguments");
    int version = atoi(argv[1]);
    open_library(argv[2]);
    if (!library)
        fail("loading the library");
    experiment = fopen(argv[4], "r");
    if (!experiment)
        fail("opening the experiment");
    instantiate(version, argv[3], argc == 6 ? argv[5] : NULL);
    run(version);
    GET(fmi2FreeInstance);
    GET(fmi3FreeInstance);
    if (version == 2)
        fmi2FreeInstance(component);
    else
        fmi3FreeInstance(component);
    return 0;
}
