"""The masters of the comparison: which runner steps with them, in which environment, how many steps."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).parents[1]
RUNNERS = Path(__file__).parent / "runners"
ENVIRONMENTS = PROJECT / "build" / "peers"
LONGEST = 300.0  # s


@dataclass(frozen=True)
class Master:
    """One master; `package` is installed in an environment of its own, `work` is FMU steps a repetition."""

    name: str
    runner: str
    work: int
    package: str | None = None
    more: tuple[str, ...] = ()


FLOOR = "bare C loop"
OURS = "dockloop"
CALLS = "bare C loop over FMI calls"
FUSED = "one FMU, dockloop export-fmu"
MASTERS = (
    Master(FLOOR, "bare_c", 400_000),
    Master(CALLS, "bare_fmi", 400_000),
    Master(FUSED, "fused", 400_000),
    Master(OURS, "dockloop_master", 400_000),
    Master("FMPy container, recorded", "fmpy_container", 400_000, more=("1",)),
    Master("FMPy container, 1000 steps a call", "fmpy_container", 400_000, more=("1000",)),
    Master("Ecos (ecospy)", "ecos", 50_000, "ecospy==0.7.2"),
    Master("libcosim (libcosimpy)", "cosim", 50_000, "libcosimpy==0.0.6"),
    Master("FMPy loop", "fmpy_loop", 50_000),
    Master("CoFMPy", "cofmpy_master", 10_000, "cofmpy==0.2.0"),
)


def python_of(master: Master) -> Path:
    """Interpreter of a master, with its package; installs it once. CalledProcessError if that fails."""
    if master.package is None:
        return Path(sys.executable)
    folder = ENVIRONMENTS / master.package.partition("=")[0]
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not (folder / "installed").is_file():
        quiet = {"check": True, "capture_output": True, "text": True}
        subprocess.run([sys.executable, "-m", "venv", folder], **quiet)
        subprocess.run([python, "-m", "pip", "install", "--quiet", master.package], **quiet)
        (folder / "installed").touch()
    return python


def measure(master: Master, spec: Path, n_fmus: int) -> dict:
    """Step a system once in a process of its own; `problem` says why not."""
    n_steps = max(2000, master.work // n_fmus // 1000 * 1000)
    environment = {**os.environ, "PYTHONPATH": str(PROJECT), "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [python_of(master), RUNNERS / f"{master.runner}.py", spec, str(n_steps), *master.more],
            check=True,
            capture_output=True,
            text=True,
            timeout=LONGEST,
            env=environment,
        )
    except subprocess.CalledProcessError as error:
        said = (error.stderr or "").strip().splitlines() or [f"exit status {error.returncode}"]
        return {"problem": said[-1][:200]}
    except subprocess.TimeoutExpired:
        return {"problem": f"not done in {LONGEST:g} s"}
    return json.loads(done.stdout.splitlines()[-1])
