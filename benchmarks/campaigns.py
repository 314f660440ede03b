"""
Many runs of the docking loop: a campaign, and a loop over FMPy's `simulate_fmu` of its container.

    python benchmarks/campaigns.py [--json] [--runs 20] [--seconds 10]

Five native FMUs, steps of 1 ms, another mass each run, one number kept of each run; in one process each.
Processor time counts, so that a busy machine does not decide.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

HERE = Path(__file__).parent
MASSES = (500.0, 900.0)


def main() -> None:
    """Measure both and show."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--part", choices=("ours", "fmpy"))
    arguments = parser.parse_args()
    if arguments.part is not None:
        part = {"ours": ours, "fmpy": fmpy}[arguments.part]
        print(json.dumps(part(arguments.runs, arguments.seconds)))
        return
    rows = [_apart(name, arguments.runs, arguments.seconds) for name in ("ours", "fmpy")]
    for row in rows:
        row["ratio"] = row["ms_per_run"] / rows[0]["ms_per_run"]
    if arguments.json:
        print(json.dumps(rows))
        return
    for row in rows:
        print(f"{row['name']:40} {row['ms_per_run']:10.2f} ms a run {row['ratio']:8.1f}")


def _apart(name: str, runs: int, seconds: float) -> dict:
    """Measure one of the two in a process of its own."""
    command = [sys.executable, __file__, "--part", name, "--runs", str(runs), "--seconds", str(seconds)]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def _masses(runs: int) -> list[float]:
    low, high = MASSES
    return [low + (high - low) * (i + 0.5) / runs for i in range(runs)]


def ours(runs: int, seconds: float) -> dict:
    """Make the runs by a campaign's process."""
    from systems import docking_loop

    from master.campaign.plan import make_plan
    from master.campaign.stepper import Stepper

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "campaign.yaml"
        campaign = {
            "system": str(docking_loop().config),
            "stop_time": seconds,
            "vary": {"spacecraft.m_s": {"values": [0.5 * sum(MASSES), *_masses(runs)]}},
            "keep": {"measures": {"rms": {"rms": "spacecraft.s_des"}}},
        }
        file.write_text(yaml.safe_dump(campaign), encoding="utf-8")
        stepper = Stepper(make_plan(file))
        stepper.row(0)  # loads
        begin = time.process_time()
        numbers = [stepper.row(1 + run).numbers["rms"] for run in range(runs)]
        spent = time.process_time() - begin
    return {"name": "dockloop sweep", "ms_per_run": 1e3 * spent / runs, "last": numbers[-1]}


def fmpy(runs: int, seconds: float) -> dict:
    """Make the runs by a loop over `simulate_fmu`, with the FMU unpacked and its description read once."""
    sys.path.insert(0, str(HERE / "runners"))
    import numpy as np
    from fmpy import extract, read_model_description, simulate_fmu
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy_container import configure
    from systems import docking_loop

    spec = json.loads(docking_loop().spec.read_text(encoding="utf-8"))
    description, configuration = configure(spec)
    description.defaultExperiment.stopTime = repr(seconds)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "unzipped").mkdir()
        file = Path(folder) / "container.fmu"
        create_container_fmu(configuration, Path(folder) / "unzipped", file)
        unpacked = extract(str(file))
        known = read_model_description(unpacked, validate=False)
        begin = 0.0
        for mass in (0.5 * sum(MASSES), *_masses(runs)):
            rows = simulate_fmu(
                unpacked,
                model_description=known,
                validate=False,
                stop_time=seconds,
                step_size=spec["step_size"],
                output_interval=spec["step_size"],
                start_values={"spacecraft.m_s": mass},
                output=["spacecraft.s_des"],
            )
            number = float(np.sqrt(np.mean(rows["spacecraft.s_des"] ** 2)))
            begin = begin or time.process_time()  # the first run loads
        spent = time.process_time() - begin
    return {"name": "FMPy simulate_fmu of its container", "ms_per_run": 1e3 * spent / runs, "last": number}


if __name__ == "__main__":
    main()
