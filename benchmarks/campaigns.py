"""
Many runs of the docking loop: a campaign, and FMPy's `simulate_fmu` of its container, alone and with Dask.

    python benchmarks/campaigns.py [--json] [--runs 20] [--seconds 10]

Five native FMUs, steps of 1 ms, another mass each run, one number kept of each run; in one process each,
with Dask in two workers that have made a run before. Processor time of all processes counts, so that a busy
machine does not decide.
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
    """Measure all and show."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--part", choices=PARTS)
    arguments = parser.parse_args()
    if arguments.part is not None:
        print(json.dumps(PARTS[arguments.part](arguments.runs, arguments.seconds)))
        return
    rows = [_apart(name, arguments.runs, arguments.seconds) for name in PARTS]
    for row in rows:
        row["ratio"] = row["ms_per_run"] / rows[0]["ms_per_run"]
    if arguments.json:
        print(json.dumps(rows))
        return
    for row in rows:
        print(f"{row['name']:40} {row['ms_per_run']:10.2f} ms a run {row['ratio']:8.1f}")


def _apart(name: str, runs: int, seconds: float) -> dict:
    """Measure one of them in a process of its own."""
    command = [sys.executable, __file__, "--part", name, "--runs", str(runs), "--seconds", str(seconds)]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def _masses(runs: int) -> list[float]:
    low, high = MASSES
    return [low + (high - low) * (i + 0.5) / runs for i in range(runs)]


def ours(runs: int, seconds: float) -> dict:
    """Make the runs by a campaign's process, in the fused form."""
    return {"name": "dockloop sweep", **_campaign(runs, seconds, is_fused=True)}


def apart(runs: int, seconds: float) -> dict:
    """Make the runs by a campaign's process that calls the FMUs."""
    return {"name": "dockloop sweep, FMUs apart", **_campaign(runs, seconds, is_fused=False)}


def _campaign(runs: int, seconds: float, *, is_fused: bool) -> dict:
    from systems import docking_loop

    from master.campaign.plan import make_plan
    from master.campaign.stepper import Stepper
    from master.fuse.runs import fused_form

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "campaign.yaml"
        campaign = {
            "system": str(docking_loop().config),
            "stop_time": seconds,
            "vary": {"spacecraft.m_s": {"values": [0.5 * sum(MASSES), *_masses(runs)]}},
            "keep": {"measures": {"rms": {"rms": "spacecraft.s_des"}}},
        }
        file.write_text(yaml.safe_dump(campaign), encoding="utf-8")
        plan = make_plan(file)
        stepper = Stepper(plan, fused_form(plan.base)) if is_fused else Stepper(plan)
        stepper.row(0)  # loads
        begin = time.process_time()
        numbers = [stepper.row(1 + run).numbers["rms"] for run in range(runs)]
        spent = time.process_time() - begin
    return {"ms_per_run": 1e3 * spent / runs, "last": numbers[-1]}


def fmpy(runs: int, seconds: float) -> dict:
    """Make the runs by a loop over `simulate_fmu`, with the FMU unpacked and its description read once."""
    with tempfile.TemporaryDirectory() as folder:
        unpacked, step = _container(Path(folder), seconds)
        begin = 0.0
        for mass in (0.5 * sum(MASSES), *_masses(runs)):
            number = _simulated(unpacked, mass, seconds, step)
            begin = begin or time.process_time()  # the first run loads
        spent = time.process_time() - begin
    return {"name": "FMPy simulate_fmu of its container", "ms_per_run": 1e3 * spent / runs, "last": number}


def dask(runs: int, seconds: float) -> dict:
    """Make the runs by tasks of a Dask cluster of two processes, as FMPy's example of it does."""
    from distributed import Client, LocalCluster

    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        unpacked, step = _container(Path(folder), seconds)
        first = 0.5 * sum(MASSES)
        for place in client.scheduler_info()["workers"]:  # the first run loads
            client.submit(_simulated, unpacked, first, seconds, step, workers=[place], pure=False).result()
        begin = time.process_time() + sum(client.run(time.process_time).values())
        tasks = [client.submit(_simulated, unpacked, mass, seconds, step) for mass in _masses(runs)]
        numbers = client.gather(tasks)
        spent = time.process_time() + sum(client.run(time.process_time).values()) - begin
    return {"name": "FMPy with Dask", "ms_per_run": 1e3 * spent / runs, "last": numbers[-1]}


def _container(folder: Path, seconds: float) -> tuple[str, float]:
    """Write FMPy's container of the loop, unpacked; return its folder and the step size [s]."""
    sys.path.insert(0, str(HERE / "runners"))
    from fmpy import extract
    from fmpy.container_fmu.cli import create_container_fmu
    from fmpy_container import configure
    from systems import docking_loop

    spec = json.loads(docking_loop().spec.read_text(encoding="utf-8"))
    description, configuration = configure(spec)
    description.defaultExperiment.stopTime = repr(seconds)
    (folder / "unzipped").mkdir()
    create_container_fmu(configuration, folder / "unzipped", folder / "container.fmu")
    return extract(str(folder / "container.fmu")), spec["step_size"]


_known: dict = {}  # descriptions by folder, read once a process


def _simulated(unpacked: str, mass: float, seconds: float, step: float) -> float:
    """Make a run with FMPy; return the root of the mean square of the motion."""
    import numpy as np
    from fmpy import read_model_description, simulate_fmu

    if unpacked not in _known:
        _known[unpacked] = read_model_description(unpacked, validate=False)
    rows = simulate_fmu(
        unpacked,
        model_description=_known[unpacked],
        validate=False,
        stop_time=seconds,
        step_size=step,
        output_interval=step,
        start_values={"spacecraft.m_s": mass},
        output=["spacecraft.s_des"],
    )
    return float(np.sqrt(np.mean(rows["spacecraft.s_des"] ** 2)))


PARTS = {"ours": ours, "apart": apart, "fmpy": fmpy, "dask": dask}
"""What is measured, each in a process of its own."""


if __name__ == "__main__":
    main()
