"""A chirp on the motion simulator, spacecraft held: run on the FMUs of a system, or a recording."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from master.coupling.schedule import make_schedule
from master.diagnosis.data.clock import ClockRules
from master.diagnosis.data.recordings import Column, Recording, Rules, read
from master.errors import ConfigError, FmuError, Problem
from master.experiment.experiment import Experiment
from master.stepping.outcome import COMPLETED, RunOptions
from master.stepping.simulate import simulate
from master.system.grid import Grid
from master.system.inputs import Feed, MeasuredInputs, with_first_values
from master.text.signal_name import SignalName

from .box import CONTACT, SENSOR, instance_of
from .chirp import Chirp, Floats

SIGNALS = {"s_cmd": "m", "s_act": "m", "f_mea": "N"}
FEWEST_SAMPLES = 500


@dataclass(frozen=True)
class Held:
    """Command, displacement [m] and force [N] of a rig whose spacecraft is held, every `period` s."""

    period: float
    s_cmd: Floats
    s_act: Floats
    f_mea: Floats


@dataclass(frozen=True)
class Parts:
    """The instances that a chirp moves."""

    plant: str
    contact: str
    sensor: str


def parts_of(experiment: Experiment) -> Parts:
    """
    Find motion simulator, contact and sensor: what leads to the contact's displacement, and takes its force.

    Raises:
        ConfigError: If one is missing.
    """
    contact = instance_of(experiment.config, CONTACT)
    sensor = instance_of(experiment.config, SENSOR)
    wires = {wire.target.name: wire.source.instance for wire in experiment.system.wires}
    plant = wires.get(f"{contact}.s_act")
    problems = [
        Problem(
            f"no {what}", where="fmus", expected="a docking rig with motion simulator, contact and sensor"
        )
        for what, name in ((CONTACT, contact), (SENSOR, sensor), ("source of the contact's s_act", plant))
        if name is None
    ]
    if problems:
        raise ConfigError(problems)
    return Parts(str(plant), str(contact), str(sensor))


def run_held(experiment: Experiment, chirp: Chirp) -> Held:
    """
    Run the chirp on the FMUs of a system, without compensator and spacecraft.

    Raises:
        ConfigError: If the system is no docking rig.
        FmuError: If an FMU fails, or the rig leaves its limits.
    """
    parts = parts_of(experiment)
    kept = [parts.plant, parts.contact, parts.sensor]
    system = replace(
        experiment.system,
        instances={name: experiment.system.instances[name] for name in kept},
        wires=tuple(
            w for w in experiment.system.wires if w.source.instance in kept and w.target.instance in kept
        ),
    )
    period = experiment.grid.step_size
    start = system.instances[parts.plant].value_of("s_act")
    command = float(start if isinstance(start, int | float) else 0.0) + chirp.samples(period)
    used = np.concatenate([command[:1], command[:-1]])  # the step to t_k uses what was set at t_(k-1)
    inputs = MeasuredInputs((Feed("chirp", f"{parts.plant}.s_cmd"),), used[:, None])
    limits = {name: limit for name, limit in experiment.limits.items() if SignalName(name).instance in kept}
    outcome = simulate(
        with_first_values(system, inputs),
        make_schedule(system, list(kept), "commissioning"),
        Grid(experiment.grid.t0, period, len(command) - 1),
        options=RunOptions(inputs=inputs, limits=limits),
    )
    if outcome.error is not None:
        raise outcome.error
    if outcome.status != COMPLETED:
        raise FmuError(parts.plant, f"the chirp {outcome.status}: {outcome.cause}")
    result = outcome.result
    return Held(period, command, result[f"{parts.plant}.s_act"], result[f"{parts.sensor}.f_mea"])


def read_held(path: Path, time: str | None = None) -> Held:
    """
    Read a recording of a rig with the columns s_cmd, s_act [m], f_mea [N] and a time [s].

    Raises:
        DataError: With every fault.
    """
    columns = {name: Column(name, unit) for name, unit in SIGNALS.items()}
    rules = Rules(fewest=FEWEST_SAMPLES, clock=ClockRules(start=None))
    found: Recording = read(path, Column(time or "time", "s"), columns, rules=rules)
    return Held(found.period, found["s_cmd"], found["s_act"], found["f_mea"])
