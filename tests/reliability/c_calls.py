"""
Random calls of our FMUs' C code, in any order and with any argument, by two threads with own instances.

    python -m tests.reliability.c_calls [CALLS [SEED [MODEL ...]]]

Each model is compiled twice: with the address and undefined-behaviour sanitizers of gcc, and with its thread
sanitizer. The calls are spread over the models; the first finding ends the harness with what it is.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from fmu_sources.composed import registry
from fmu_sources.export import native
from tests.fmu_sources.export.native.native_library import GUID
from tests.fmu_sources.export.native.native_model import MODEL
from tests.fmu_sources.export.native.test_native_fuzz import FLAGS, HOST

CALLS_A_SEQUENCE = 240
THREADS = 2
SANITIZERS = {
    "address, undefined": FLAGS,
    "thread": ("-std=c11", "-g", "-O1", "-fsanitize=thread"),
}


def compiled(name: str, flags: tuple[str, ...], folder: Path) -> Path:
    """Compile a model with the host that calls it."""
    model = MODEL if name == "specimen" else registry.load(name)
    for file, content in native.generate(model, GUID).items():
        (folder / file).write_bytes(content)
    files = [*sorted(map(str, folder.glob("*.c"))), str(HOST)]
    host = folder / "host"
    command = ["gcc", *flags, "-I", str(folder), *files, "-lm", "-pthread", "-o", str(host)]
    subprocess.run(command, check=True)
    return host


def main() -> None:
    """Call, and print a line a model and sanitizer."""
    calls = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    names = sys.argv[3:] or [*registry.model_files(), "specimen"]
    each = -(-calls // (len(names) * len(SANITIZERS) * CALLS_A_SEQUENCE * THREADS))
    done = 0
    for name in names:
        for sanitizer, flags in SANITIZERS.items():
            with tempfile.TemporaryDirectory() as folder:
                host = compiled(name, flags, Path(folder))
                words = [str(host), str(each), str(seed), str(THREADS)]
                run = subprocess.run(words, capture_output=True, text=True, check=False)
            sys.stdout.write(f"{name}, {sanitizer}: {run.stdout}")
            sys.stdout.flush()
            if run.returncode != 0:
                sys.exit(f"{name}, {sanitizer}: exit status {run.returncode}\n{run.stderr}")
            done += each * CALLS_A_SEQUENCE * THREADS
    sys.stdout.write(f"{done} calls of {len(names)} models, 0 findings\n")


if __name__ == "__main__":
    main()
