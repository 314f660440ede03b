/* FMI 2.0 and 3.0: does the deed that the parameter names, in the call that another one names. No headers of FMI. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NOTHING, SEGFAULT, ABORT, EXIT, HANG, EAT, MOVE, ROUND, ERROR, SAY, WRITE, CONNECT, CHATTER, COUNT_ALOUD };
enum { AT_STEP, AT_SET, AT_GET, AT_ENTER, AT_EXIT, AT_SAVE, AT_END };
enum { X = 0, Y = 1, N = 2, COUNT = 3, DEED = 8, WHEN = 9, FROM = 10, INPUT = 11 };

typedef struct {
    double x, y, input;
    int n, count, deed, when, from, steps;
    void *callbacks;
    void *environment;
} Fmu;

static int done(Fmu *c, int when);

#ifdef THREE
typedef void Log(void *environment, int status, const char *category, const char *text);
static void say(Fmu *c, const char *text) { ((Log *)c->callbacks)(c->environment, 1, "faulty", text); }
#else
typedef void Log(void *environment, const char *name, int status, const char *category, const char *text, ...);
typedef struct {
    Log *log;
    void *allocate, *free, *finished, *environment;
} Callbacks;
static void say(Fmu *c, const char *text) {
    Callbacks *callbacks = c->callbacks;
    callbacks->log(callbacks->environment, "faulty", 1, "faulty", "%s", text);
}
#endif

static int done(Fmu *c, int when) {
    if (c->when != when || c->steps < c->from) {
        return 0;
    }
    switch (c->deed) {
    case SEGFAULT:
        say(c, "about to fall");
        *(volatile int *)8 = 1;
        return 0;
    case ABORT:
        abort();
    case EXIT:
        exit(7);
    case HANG:
        for (;;) {
            usleep(1000);
        }
    case EAT:
        for (;;) {
            char *memory = malloc(1 << 20);
            memset(memory, 1, 1 << 20);
        }
    case MOVE:
        return chdir("/") != 0;
    case ROUND:
        fesetround(FE_UPWARD);
        return 0;
    case ERROR:
        say(c, "out of range");
        return 3;
    case SAY:
        say(c, "a word");
        return 0;
    case CHATTER:
        for (int i = 0; i < 1000; i++) {
            say(c, "a flood of words");
        }
        return 0;
    case COUNT_ALOUD: {
        char text[64];
        snprintf(text, sizeof text, "a word in step number %d", c->steps);
        say(c, text);
        return 0;
    }
    case WRITE: {
        int file = open(getenv("FAULTY_FILE"), O_CREAT | O_WRONLY, 0600);
        char name[64];
        say(c, file < 0 ? "could not write outside" : "wrote outside");
        snprintf(name, sizeof name, "%s/own", getenv("TMPDIR"));
        say(c, open(name, O_CREAT | O_WRONLY, 0600) < 0 ? "could not write inside" : "wrote inside");
        say(c, mkdir("../faulty_folder", 0700) < 0 ? "could not make a folder" : "made a folder");
        rmdir("../faulty_folder");
        return 0;
    }
    case CONNECT:
        say(c, socket(AF_INET, SOCK_STREAM, 0) < 0 ? "no network" : "a network");
        say(c, socket(AF_UNIX, SOCK_STREAM, 0) < 0 ? "no local sockets" : "local sockets");
        say(c, kill(getppid(), 0) < 0 ? "no signals to others" : "signals to others");
        return 0;
    default:
        return 0;
    }
}

static void *make(void *callbacks, void *environment) {
    Fmu *c = calloc(1, sizeof *c);
    c->callbacks = callbacks;
    c->environment = environment;
    c->x = 0.3;
    return c;
}

static int step(Fmu *c) {
    c->x = 3.9 * c->x * (1.0 - c->x) + 1e-3 * c->input / (1.0 + c->input * c->input);
    c->y = c->x / 3.0;
    c->n = 7 * c->n + (int)(1000.0 * c->x);
    c->n %= 10007;
    c->steps++;
    c->count = c->steps;
    return done(c, AT_STEP);
}

static int set_real(Fmu *c, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] == INPUT) {
            c->input = v[i];
        }
    }
    return done(c, AT_SET);
}
static int get_real(Fmu *c, const unsigned *r, size_t n, double *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == X ? c->x : r[i] == Y ? c->y : c->input;
    }
    return done(c, AT_GET);
}
static int set_integer(Fmu *c, const unsigned *r, size_t n, const int *v) {
    for (size_t i = 0; i < n; i++) {
        *(r[i] == DEED ? &c->deed : r[i] == WHEN ? &c->when : &c->from) = v[i];
    }
    return 0;
}
static int get_integer(Fmu *c, const unsigned *r, size_t n, int *v) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == N ? c->n : c->count;
    }
    return 0;
}
static int save(Fmu *c, Fmu **state) {
    if (!*state) {
        *state = malloc(sizeof **state);
    }
    **state = *c;
    return done(c, AT_SAVE);
}

#ifdef THREE
void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool events, bool early, const unsigned *required, size_t n,
                                  void *environment, void *log, void *update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)update;
    return make(log, environment);
}
void fmi3FreeInstance(Fmu *c) { done(c, AT_END); free(c); }
int fmi3EnterInitializationMode(Fmu *c, bool a, double b, double t, bool d, double e) {
    (void)a, (void)b, (void)t, (void)d, (void)e;
    return done(c, AT_ENTER);
}
int fmi3ExitInitializationMode(Fmu *c) { return done(c, AT_EXIT); }
int fmi3Terminate(Fmu *c) { (void)c; return 0; }
int fmi3DoStep(Fmu *c, double t, double h, bool no_set, bool *event, bool *end, bool *early, double *last) {
    (void)no_set;
    *event = *end = *early = false;
    *last = t + h;
    return step(c);
}
int fmi3SetFloat64(Fmu *c, const unsigned *r, size_t n, const double *v, size_t m) { (void)m; return set_real(c, r, n, v); }
int fmi3GetFloat64(Fmu *c, const unsigned *r, size_t n, double *v, size_t m) { (void)m; return get_real(c, r, n, v); }
int fmi3SetInt32(Fmu *c, const unsigned *r, size_t n, const int *v, size_t m) { (void)m; return set_integer(c, r, n, v); }
int fmi3GetInt32(Fmu *c, const unsigned *r, size_t n, int *v, size_t m) { (void)m; return get_integer(c, r, n, v); }
int fmi3GetFMUState(Fmu *c, Fmu **state) { return save(c, state); }
int fmi3SetFMUState(Fmu *c, Fmu *state) { *c = *state; return 0; }
int fmi3FreeFMUState(Fmu *c, Fmu **state) { (void)c; free(*state); *state = NULL; return 0; }
#else
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      void *callbacks, int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)visible, (void)logging;
    return make(callbacks, NULL);
}
void fmi2FreeInstance(Fmu *c) { done(c, AT_END); free(c); }
int fmi2SetupExperiment(Fmu *c, int a, double b, double t, int d, double e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return 0;
}
int fmi2EnterInitializationMode(Fmu *c) { return done(c, AT_ENTER); }
int fmi2ExitInitializationMode(Fmu *c) { return done(c, AT_EXIT); }
int fmi2Terminate(Fmu *c) { (void)c; return 0; }
int fmi2DoStep(Fmu *c, double t, double h, int no_set) { (void)t, (void)h, (void)no_set; return step(c); }
int fmi2SetReal(Fmu *c, const unsigned *r, size_t n, const double *v) { return set_real(c, r, n, v); }
int fmi2GetReal(Fmu *c, const unsigned *r, size_t n, double *v) { return get_real(c, r, n, v); }
int fmi2SetInteger(Fmu *c, const unsigned *r, size_t n, const int *v) { return set_integer(c, r, n, v); }
int fmi2GetInteger(Fmu *c, const unsigned *r, size_t n, int *v) { return get_integer(c, r, n, v); }
int fmi2GetFMUstate(Fmu *c, Fmu **state) { return save(c, state); }
int fmi2SetFMUstate(Fmu *c, Fmu *state) { *c = *state; return 0; }
int fmi2FreeFMUstate(Fmu *c, Fmu **state) { (void)c; free(*state); *state = NULL; return 0; }
#endif
