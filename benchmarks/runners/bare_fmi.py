"""
A C program that makes the FMI calls of a master and nothing else.

Each tick is straight-line code: the inputs of each FMU are set from outputs, it is stepped, its outputs are
read, and all outputs are written as a row. The libraries are those inside the FMUs, loaded as a host does.
With one FMU alone it is the host of a system that was exported as one FMU.
"""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

from measure import answer

FLAGS = ("-std=c11", "-O3", "-ffp-contract=off")
CASTS = {"Real": "double", "Integer": "int", "Boolean": "int"}


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    run(spec, n_steps, Path(spec_path).parent / "bare_fmi")


def run(spec: dict, n_steps: str, folder: Path) -> None:
    """Compile the program of a system, run it and answer."""
    program = build(spec, folder)
    done = subprocess.run([program, n_steps], check=True, capture_output=True, text=True)
    wall, cpu, *values = done.stdout.split()
    names = [f"{n}.{v}" for n, fmu in spec["fmus"].items() for v in fmu["outputs"]]
    compiler = subprocess.run(["cc", "--version"], check=True, capture_output=True, text=True).stdout
    answer(
        (float(wall), float(cpu)),
        int(n_steps),
        compiler.splitlines()[0],
        zip(names, map(float, values), strict=True),
    )


def build(spec: dict, folder: Path) -> Path:
    """Unpack the libraries and compile the program."""
    import fmpy

    folder.mkdir(exist_ok=True)
    libraries = {}
    for name, fmu in spec["fmus"].items():
        libraries[name] = folder / f"{name}.so"
        with zipfile.ZipFile(fmu["path"]) as archive:
            libraries[name].write_bytes(archive.read(f"binaries/linux64/{fmu['identifier']}.so"))
    source = folder / "main.c"
    source.write_text(_program(spec, libraries), encoding="utf-8")
    headers = Path(fmpy.__file__).parent / "c-code"
    program = folder / "bare_fmi"
    subprocess.run(["cc", *FLAGS, "-I", headers, "-o", program, source, "-ldl", "-lm"], check=True)
    return program


def _program(spec: dict, libraries: dict[str, Path]) -> str:
    fmus = spec["fmus"]
    number = {name: i for i, name in enumerate(fmus)}
    wires = {n: [w for w in spec["connections"] if w[1].split(".", 1)[0] == n] for n in fmus}
    column = {}
    for name, fmu in fmus.items():
        for variable in fmu["outputs"]:
            column[f"{name}.{variable}"] = len(column)
    tables, loads, starts, exits, passes, ticks, ends = [], [], [], [], [], [], []
    for name, fmu in fmus.items():
        i = number[name]
        tables += _tables(i, name, fmu, wires[name])
        loads.append(f'load(&f{i}, "{libraries[name]}", "{fmu["token"]}", "{name}");')
        starts += [_start(i, fmu, v, x) for v, x in fmu["start"].items()]
        starts += [f"OK(f{i}.setup(f{i}.c, 0, 0.0, 0.0, 0, 0.0));", f"OK(f{i}.enter(f{i}.c));"]
        passes += [*_set(i, name, fmu, wires[name], column), *_get(i, name, fmu, column)]
        exits.append(f"OK(f{i}.exit(f{i}.c));")
        ends.append(f"f{i}.free(f{i}.c);")
    for group in spec["order"]:
        for name in group:
            ticks += _set(number[name], name, fmus[name], wires[name], column)
        for name in group:
            i = number[name]
            ticks += [f"OK(f{i}.step(f{i}.c, t, h, 1));", *_get(i, name, fmus[name], column)]
    return _TEXT.format(
        fmus="\n".join(f"static Fmu f{i};" for i in number.values()),
        tables="\n".join(tables),
        loads="\n    ".join(loads),
        starts="\n    ".join(starts),
        passes="\n        ".join(passes),
        exits="\n    ".join(
            [*exits, *(line for n, f in fmus.items() for line in _get(number[n], n, f, column))]
        ),
        ticks="\n    ".join(ticks),
        ends="\n    ".join(ends),
        n=len(column),
        n_passes=len(fmus) + 1,
        h=repr(spec["step_size"]),
    )


def _kinds(fmu: dict) -> dict[str, list[str]]:
    """Outputs by their kind."""
    found: dict[str, list[str]] = {}
    for variable in fmu["outputs"]:
        found.setdefault(fmu["kinds"][variable], []).append(variable)
    return found


def _tables(i: int, name: str, fmu: dict, wires: list) -> Iterator[str]:
    inputs = [fmu["references"][w[1].split(".", 1)[1]] for w in wires]
    if inputs:
        yield f"static const unsigned in{i}[] = {{{', '.join(map(str, inputs))}}};"
    for kind, variables in _kinds(fmu).items():
        references = ", ".join(str(fmu["references"][v]) for v in variables)
        yield f"static const unsigned {kind}{i}[] = {{{references}}};"


def _start(i: int, fmu: dict, variable: str, value: float) -> str:
    kind = fmu["kinds"][variable]
    text = repr(value) if kind == "Real" else str(int(value))
    array = f"(const unsigned[]){{{fmu['references'][variable]}}}, 1, (const {CASTS[kind]}[]){{{text}}}"
    return f"OK(f{i}.set{kind}(f{i}.c, {array}));"


def _set(i: int, name: str, fmu: dict, wires: list, column: dict[str, int]) -> Iterator[str]:
    if wires:
        values = ", ".join(f"y[{column[source]}]" for source, _ in wires)
        yield f"OK(f{i}.setReal(f{i}.c, in{i}, {len(wires)}, (const double[]){{{values}}}));"


def _get(i: int, name: str, fmu: dict, column: dict[str, int]) -> Iterator[str]:
    """Read the outputs of an FMU, straight into the row where they are neighbours in it."""
    for kind, variables in _kinds(fmu).items():
        places = [column[f"{name}.{v}"] for v in variables]
        n, first = len(places), places[0]
        if kind == "Real" and places == list(range(first, first + n)):
            yield f"OK(f{i}.getReal(f{i}.c, Real{i}, {n}, y + {first}));"
            continue
        own = f"got{i}_{kind}"
        copies = " ".join(f"y[{place}] = {own}[{j}];" for j, place in enumerate(places))
        yield f"{CASTS[kind]} {own}[{n}]; OK(f{i}.get{kind}(f{i}.c, {kind}{i}, {n}, {own})); {copies}"


_TEXT = """\
#define _POSIX_C_SOURCE 199309L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

typedef struct {{
    fmi2Component c;
    fmi2SetupExperimentTYPE *setup;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *exit;
    fmi2DoStepTYPE *step;
    fmi2FreeInstanceTYPE *free;
    fmi2SetRealTYPE *setReal;
    fmi2GetRealTYPE *getReal;
    fmi2SetIntegerTYPE *setInteger;
    fmi2GetIntegerTYPE *getInteger;
    fmi2SetBooleanTYPE *setBoolean;
    fmi2GetBooleanTYPE *getBoolean;
}} Fmu;

#define OK(call) if ((call) > fmi2Warning) {{ fputs(#call " failed\\n", stderr); exit(1); }}

{fmus}
{tables}

static void say(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String text, ...) {{
    (void)e, (void)s, (void)c;
    fprintf(stderr, "%s: %s\\n", n, text);
}}

static const fmi2CallbackFunctions callbacks = {{say, calloc, free, NULL, NULL}};

static void load(Fmu *fmu, const char *path, const char *token, const char *name) {{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {{
        fputs(dlerror(), stderr);
        exit(1);
    }}
    fmu->setup = (fmi2SetupExperimentTYPE *)dlsym(library, "fmi2SetupExperiment");
    fmu->enter = (fmi2EnterInitializationModeTYPE *)dlsym(library, "fmi2EnterInitializationMode");
    fmu->exit = (fmi2ExitInitializationModeTYPE *)dlsym(library, "fmi2ExitInitializationMode");
    fmu->step = (fmi2DoStepTYPE *)dlsym(library, "fmi2DoStep");
    fmu->free = (fmi2FreeInstanceTYPE *)dlsym(library, "fmi2FreeInstance");
    fmu->setReal = (fmi2SetRealTYPE *)dlsym(library, "fmi2SetReal");
    fmu->getReal = (fmi2GetRealTYPE *)dlsym(library, "fmi2GetReal");
    fmu->setInteger = (fmi2SetIntegerTYPE *)dlsym(library, "fmi2SetInteger");
    fmu->getInteger = (fmi2GetIntegerTYPE *)dlsym(library, "fmi2GetInteger");
    fmu->setBoolean = (fmi2SetBooleanTYPE *)dlsym(library, "fmi2SetBoolean");
    fmu->getBoolean = (fmi2GetBooleanTYPE *)dlsym(library, "fmi2GetBoolean");
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)dlsym(library, "fmi2Instantiate");
    fmu->c = instantiate(name, fmi2CoSimulation, token, "", &callbacks, fmi2False, fmi2False);
    if (fmu->c == NULL) {{
        exit(1);
    }}
}}

static double y[{n}];

static void tick(double t, double h) {{
    {ticks}
}}

static double now(clockid_t clock) {{
    struct timespec at;
    clock_gettime(clock, &at);
    return at.tv_sec + 1e-9 * at.tv_nsec;
}}

int main(int argc, char **argv) {{
    const long n = argc > 1 ? atol(argv[1]) : 1000;
    double *rows = malloc(sizeof y * (n + 1));
    {loads}
    {starts}
    for (int i = 0; i < {n_passes}; i++) {{
        {passes}
    }}
    {exits}
    memset(rows, 0, sizeof y * (n + 1)); /* so that the first use of memory is not timed */
    const double begin = now(CLOCK_MONOTONIC), begin_cpu = now(CLOCK_PROCESS_CPUTIME_ID);
    for (long k = 0; k < n; k++) {{
        tick(k * {h}, {h});
        memcpy(rows + {n} * k, y, sizeof y);
    }}
    const double cpu = now(CLOCK_PROCESS_CPUTIME_ID) - begin_cpu, wall = now(CLOCK_MONOTONIC) - begin;
    printf("%.17g %.17g\\n", wall, cpu);
    for (int i = 0; i < {n}; i++) {{
        printf("%.17g\\n", rows[{n} * (n - 1) + i]);
    }}
    {ends}
    return 0;
}}
"""

if __name__ == "__main__":
    main(*sys.argv[1:])
