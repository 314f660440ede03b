"""
The floor: a C program with the same generated model functions, without FMI and without a master.

Each tick is straight-line code: inputs from outputs, one call of each kernel, and a row of all outputs.
The kernels are the sources inside the FMUs, compiled by the compiler of the FMUs with their flags, optimised
as a whole; the bits are the same.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

from measure import answer

from fmu_sources.export.native.compile import CODE_FLAGS
from fmu_sources.export.native.platforms import LINUX_FLAGS

FLAGS = (*CODE_FLAGS, *LINUX_FLAGS)
FILES = ("equations.c", "integrate.c", "model_equations.c", "model_variables.c")
NAMES = (
    *(f"model_{n}" for n in ("initial", "update", "derivatives", "outputs", "faults", "outputs_along")),
    *("model_variables", "model_readable", "model_inputs", "model_fault_texts", "model_restarting"),
    *("integrate", "n_substeps", "remember_inputs"),
    *("apply_initial", "apply_update", "apply_outputs", "kernel_defaults", "kernel_start", "kernel_step"),
)


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    program = build(spec, Path(spec_path).parent / "floor")
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
    """Compile the kernels of all models and the program of this system."""
    folder.mkdir(exist_ok=True)
    models = {fmu["identifier"]: fmu["path"] for fmu in spec["fmus"].values()}
    objects = [o for name, path in models.items() for o in _kernel(name, path, folder)]
    main_file = folder / "main.c"
    sizes = {name: _size(folder / name / "model_data.h") for name in models}
    main_file.write_text(_main(spec, sizes), encoding="utf-8")
    program = folder / "floor"
    subprocess.run(["cc", "-o", program, main_file, *objects, *FLAGS], check=True)
    return program


def _kernel(name: str, fmu: str, folder: Path) -> list[Path]:
    place = folder / name
    place.mkdir(exist_ok=True)
    with zipfile.ZipFile(fmu) as archive:
        for member in archive.namelist():
            if member.startswith("sources/") and member.endswith((".c", ".h")):
                (place / Path(member).name).write_bytes(archive.read(member))
    (place / "kernel.c").write_bytes((Path(__file__).parent / "kernel.c").read_bytes())
    objects = []
    for file in (*FILES, "kernel.c"):
        objects.append(place / (file + ".o"))
        renamed = [f"-D{n}={name}_{n}" for n in NAMES]
        subprocess.run(["cc", *FLAGS, *renamed, "-c", "-o", objects[-1], place / file], check=True)
    return objects


def _size(header: Path) -> int:
    """Number of doubles that a model's data take, generously."""
    counts = dict(re.findall(r"(N_\w+) = (\d+)", header.read_text(encoding="utf-8")))
    groups = ("N_PARAMETERS", "N_INPUTS", "N_STATES", "N_OUTPUTS")
    return sum(int(counts[g]) for g in groups) + max(1, int(counts["N_INPUTS"])) + 2


def _main(spec: dict, sizes: dict) -> str:
    fmus = spec["fmus"]
    ids = {name: i for i, name in enumerate(fmus)}
    incoming = {name: [c for c in spec["connections"] if c[1].split(".")[0] == name] for name in fmus}

    def cell(signal: str) -> str:
        name, variable = signal.split(".", 1)
        return f"d{ids[name]}.values[{fmus[name]['references'][variable]}]"

    def pull(name: str) -> list[str]:
        return [f"{cell(target)} = {cell(source)};" for source, target in incoming[name]]

    tick = []
    for group in spec["order"]:
        tick += [line for name in group for line in pull(name)]
        tick += [f"{fmus[n]['identifier']}_kernel_step(&d{ids[n]}, t, h);" for n in group]
    outputs = [cell(f"{n}.{v}") for n, fmu in fmus.items() for v in fmu["outputs"]]
    record = [f"row[{i}] = {place};" for i, place in enumerate(outputs)]
    starts = []
    for name, fmu in fmus.items():
        table = f"s{ids[name]}"
        starts.append(f"{fmu['identifier']}_kernel_defaults({table});")
        starts += [f"{table}[{fmu['references'][v]}] = {float(x)!r};" for v, x in fmu["start"].items()]
    passes = []
    for name in fmus:
        table, d = f"s{ids[name]}", f"d{ids[name]}"
        for source, target in incoming[name]:
            passes.append(f"{table}[{fmus[name]['references'][target.split('.', 1)[1]]}] = {cell(source)};")
        passes.append(f"{fmus[name]['identifier']}_kernel_start(&{d}, {table});")
    return _PROGRAM.format(
        declarations="\n".join(_declarations(fmus, ids, sizes)),
        starts="\n    ".join(starts),
        passes="\n        ".join(passes),
        n_fmus=len(fmus),
        tick="\n    ".join(tick),
        record="\n    ".join(record),
        n_outputs=len(outputs),
        h=repr(spec["step_size"]),
    )


def _declarations(fmus: dict, ids: dict, sizes: dict) -> list[str]:
    lines = []
    for identifier in dict.fromkeys(f["identifier"] for f in fmus.values()):
        lines.append(f"void {identifier}_kernel_defaults(double *values);")
        lines.append(f"void {identifier}_kernel_start(void *data, const double *values);")
        lines.append(f"void {identifier}_kernel_step(void *data, double t, double h);")
    for name, fmu in fmus.items():
        i, size = ids[name], sizes[fmu["identifier"]]
        lines.append(f"static struct {{ double values[{size}]; }} d{i}; static double s{i}[{size}];")
    return lines


_PROGRAM = """\
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

{declarations}

static void tick(double t, double h, double *row) {{
    {tick}
    {record}
}}

static double now(clockid_t clock) {{
    struct timespec at;
    clock_gettime(clock, &at);
    return at.tv_sec + 1e-9 * at.tv_nsec;
}}

int main(int argc, char **argv) {{
    const long n = argc > 1 ? atol(argv[1]) : 1000;
    double *rows = malloc(sizeof(double) * {n_outputs} * (n + 1));
    {starts}
    for (int i = 0; i <= {n_fmus}; i++) {{
        {passes}
    }}
    const double begin = now(CLOCK_MONOTONIC), begin_cpu = now(CLOCK_PROCESS_CPUTIME_ID);
    for (long k = 0; k < n; k++) {{
        tick(k * {h}, {h}, rows + {n_outputs} * k);
    }}
    const double cpu = now(CLOCK_PROCESS_CPUTIME_ID) - begin_cpu, wall = now(CLOCK_MONOTONIC) - begin;
    printf("%.17g %.17g\\n", wall, cpu);
    for (int i = 0; i < {n_outputs}; i++) {{
        printf("%.17g\\n", rows[{n_outputs} * (n - 1) + i]);
    }}
    return 0;
}}
"""

if __name__ == "__main__":
    main(*sys.argv[1:])
