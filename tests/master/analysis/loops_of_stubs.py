"""A mass on a spring, each an FMU of its own, and the linearisation of a system of stubs."""

from __future__ import annotations

from master.analysis.closed_loop.linearise import Linearisation
from master.experiment.experiment import Experiment
from tests.stubs import METRE, NEWTON, Block, variables

STEP = 1e-3


def mass(m=1.0):
    """X'' = f/m by the semi-implicit Euler method."""

    def law(t, h, v):
        speed = v["v"] + h * v["f"] / m
        return {"v": speed, "x": v["x"] + h * speed}

    ports = variables(
        ("f", "input", {"unit": NEWTON}),
        ("x", "output", {"unit": METRE, "initial": "exact"}),
        ("v", "local", {"initial": "exact"}),
    )
    return Block(law, ports)


def linearisation_of(stubs):
    experiment = Experiment(stubs.loaded.config, None, stubs.system, stubs.schedule)
    return Linearisation(experiment, stubs.factory)
