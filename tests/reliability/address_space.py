"""
Commands with less and less address space: each does its work, or says in words that there is too little.

    python -m tests.reliability.address_space [--limits 3000,2000,1400] [--commands run,check] [--seconds 300]

A fault is a traceback, an exit status that the command has for nothing, silence, or no end in time.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).parents[2]
MEGABYTE = 1024  # of the unit of `ulimit -v`
LIMITS = (3000, 2600, 2200, 1800, 1400, 1000, 700, 500, 300, 150)
SHORT = ("--stop-time", "0.05")
COMMANDS = {
    "check": ("check", "low_frequency"),
    "run": ("run", "low_frequency", *SHORT, "--output", "out"),
    "checkpoint": ("run", "low_frequency", *SHORT, "--checkpoint", "1s", "--output", "out"),
    "isolate": ("run", "low_frequency", *SHORT, "--isolate", "all", "--output", "out"),
    "sweep": ("sweep", "campaign.yaml", "--output", "out"),
    "diagnose": ("diagnose", str(PROJECT / "configs" / "measured" / "first_case.yaml"), "--output", "out"),
}
CAMPAIGN = """\
system: low_frequency
stop_time: 0.05
vary: {spacecraft.m_s: {uniform: [800, 820]}}
design: {method: sobol, size: 4, seed: 1}
"""
ALLOWED = (0, 2, 3)


@dataclass(frozen=True)
class Ending:
    """How a command ended; `status` is None without an end."""

    status: int | None
    said: str

    def fault(self) -> str:
        """What is wrong with it; empty if nothing is."""
        if self.status is None:
            return "no end"
        if "Traceback" in self.said:
            return "a traceback"
        if self.status not in ALLOWED:
            return f"exit status {self.status}"
        return "" if self.status == 0 or self.said.strip() else "no word"


def ending(words: tuple[str, ...], megabytes: int, seconds: float) -> Ending:
    """Run a command with a limit of its address space."""
    with tempfile.TemporaryDirectory(prefix="dockloop-", ignore_cleanup_errors=True) as place:
        command = ["sh", "-c", f'ulimit -v {megabytes * MEGABYTE}; exec "$@"', "sh"]
        command += [sys.executable, "-m", "master", *words]
        environment = os.environ | {"PYTHONPATH": str(PROJECT)}
        (Path(place) / "campaign.yaml").write_text(CAMPAIGN)
        said = Path(place) / "said"
        with said.open("wb") as file:
            process = subprocess.Popen(
                command, cwd=place, env=environment, stdout=file, stderr=file, start_new_session=True
            )
            status: int | None = None
            with suppress(subprocess.TimeoutExpired):
                status = process.wait(seconds)
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return Ending(status, said.read_text(encoding="utf-8", errors="replace"))


def main() -> None:
    """Print a line a command and limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--limits", default=",".join(map(str, LIMITS)))
    parser.add_argument("--commands", default=",".join(COMMANDS))
    parser.add_argument("--seconds", type=float, default=300.0)
    chosen = parser.parse_args()
    faults = 0
    for name in chosen.commands.split(","):
        for megabytes in map(int, chosen.limits.split(",")):
            end = ending(COMMANDS[name], megabytes, chosen.seconds)
            fault = end.fault()
            faults += bool(fault)
            last = (end.said.strip().splitlines() or [""])[-1]
            sys.stdout.write(f"{name}, {megabytes} MB: {end.status}, {fault or 'good'}: {last[:150]}\n")
            if fault:
                sys.stdout.write("".join(f"    {line}\n" for line in end.said.splitlines()[-12:]))
            sys.stdout.flush()
    sys.stdout.write(f"{faults} faults\n")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
