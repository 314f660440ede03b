"""Runs of foreign FMUs, and where they can be compiled."""

import sys

import pytest
import yaml

from master.api import prepare_to_run
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

COMPILED = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="compiles for Linux on x86_64"),
]


def run(tmp_path, fmus, connections=(), **more):
    """Step for 0.5 s with 0.1 s, along the order of the FMUs."""
    given = {"name": "foreign", "step_size": 0.1, "stop_time": 0.5, "fmus": fmus}
    given |= {"connections": list(connections), "coupling": {"order": list(fmus)}} | more
    file = tmp_path / "system.yaml"
    file.write_text(yaml.safe_dump(given))
    experiment = prepare_to_run(file)
    options = RunOptions(scenario=experiment.scenario)
    return simulate(experiment.system, experiment.schedule, experiment.grid, options=options)


def wires(*pairs):
    return [{"from": source, "to": target} for source, target in pairs]
