/* Preloaded: lets the n-th write, rename or fsync in a folder fail, or end the process amid it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static char folder[4096];
static long left = -1; /* calls until the fault; below 0: none is planned */
static int error = 0;  /* 0: SIGKILL */
static int lasts = 0;  /* every later call fails too, as on a full disk */
static int has_begun = 0;
static long calls = 0;

void fault_arm(const char *in_folder, long after, int number, int for_good) {
    snprintf(folder, sizeof folder, "%s", in_folder);
    left = after;
    error = number;
    lasts = for_good;
    has_begun = 0;
    calls = 0;
}

long fault_calls(void) { return calls; }

static int is_inside(const char *path) { return folder[0] && strncmp(path, folder, strlen(folder)) == 0; }

static int is_file_inside(int descriptor) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n <= 0) return 0;
    path[n] = 0;
    return is_inside(path);
}

static int is_due(void) {
    calls++;
    if (has_begun) return lasts;
    if (left < 0 || left-- > 0) return 0;
    has_begun = 1;
    return 1;
}

static int fail(void) {
    if (error == 0) kill(getpid(), SIGKILL);
    errno = error;
    return -1;
}

ssize_t write(int descriptor, const void *data, size_t n) {
    static ssize_t (*real)(int, const void *, size_t);
    if (!real) real = (ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write");
    if (!is_file_inside(descriptor) || !is_due()) return real(descriptor, data, n);
    if (error == 0 && n > 1) real(descriptor, data, n / 2); /* as a kill amid a write leaves it */
    return fail();
}

int rename(const char *from, const char *to) {
    static int (*real)(const char *, const char *);
    if (!real) real = (int (*)(const char *, const char *))dlsym(RTLD_NEXT, "rename");
    return is_inside(to) && is_due() ? fail() : real(from, to);
}

int fsync(int descriptor) {
    static int (*real)(int);
    if (!real) real = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
    return is_file_inside(descriptor) && is_due() ? fail() : real(descriptor);
}
