"""The systems that all masters step, written down once: a YAML file for ours, a JSON file for the others."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import yaml
from ring_model import Link

from fmu_sources.composed.registry import load, modules
from fmu_sources.export.native import generate
from fmu_sources.export.native_flavour import NativeSources, host_binaries, native_sources, pack_native
from master.api import prepare_to_run
from master.comparison.cells import Cell
from master.comparison.methods import all_methods
from master.comparison.systems import Base, put_method
from master.experiment.experiment import Experiment
from master.fmi.description import Kind

PROJECT = Path(__file__).parents[1]
BUILD = PROJECT / "build" / "benchmarks"
RING_TOKEN = "{benchmark-ring}"
STEP = 1e-3
LONG = 1e4  # s; runs are cut by their number of steps


@dataclass(frozen=True)
class Case:
    """One system: `config` for our master, `spec` for the others."""

    name: str
    config: Path
    spec: Path


def docking_loop(fmi_version: str = "2.0", method: str | None = None) -> Case:
    """
    The paper's loop at low frequency: five native FMUs of one FMI version, in the paper's order.

    `method`: one of the suite in the place of the paper's compensator.
    """
    config = PROJECT / "configs" / "low_frequency.yaml"
    data = yaml.safe_load(config.read_text(encoding="utf-8"))
    data["fmus"].pop("ideal")
    for choice in ("identifier", "preset"):  # at their defaults; no peer but FMPy can set an enumeration
        data["fmus"]["compensator"]["parameters"].pop(choice)
    data["coupling"]["order"].remove("ideal")
    if method is not None:
        put_method(data, Base(config), Cell(), all_methods()[method])
    for given in data["fmus"].values():
        model = given["source"]
        given["source"] = str(build(native_sources(load(model), *modules(model)), fmi_version))
    data = {key: data[key] for key in ("step_size", "fmus", "coupling", "connections")}
    name = "docking_loop" if method is None else f"docking_loop_{method}"
    return write_case(name + _suffix(fmi_version), data)


def ring(n: int, link: Link | None = None) -> Case:
    """N links in a ring, side by side; all inputs of a link follow its neighbour."""
    link = link or Link()
    source = str(build(NativeSources(link, RING_TOKEN, generate(link, RING_TOKEN))))
    fmus = {f"link{i}": {"source": source, "start": {"x": math.sin(2.0 * math.pi * i / n)}} for i in range(n)}
    wires = [
        {"from": f"link{i}.x", "to": f"link{(i + 1) % n}.u[{j}]"}
        for i in range(n)
        for j in range(1, link.n_inputs + 1)
    ]
    return write_case(
        f"ring_{n}" if (link.n_inputs, link.n_more) == (1, 0) else f"ring_{n}_{link.name}",
        {"step_size": STEP, "fmus": fmus, "coupling": {"order": [list(fmus)]}, "connections": wires},
    )


def build(sources: NativeSources, fmi_version: str = "2.0") -> Path:
    """Build an FMU with the compiler of this machine, which also compiles the floor."""
    path = BUILD / f"{sources.model.name}{_suffix(fmi_version)}.fmu"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(pack_native(sources, host_binaries(sources), fmi_version))
    return path


def _suffix(fmi_version: str) -> str:
    return "" if fmi_version == "2.0" else f"_fmi{fmi_version[0]}"


def write_case(name: str, data: dict) -> Case:
    """Write both files of a system."""
    folder = BUILD / name
    folder.mkdir(parents=True, exist_ok=True)
    config, spec = folder / "system.yaml", folder / "system.json"
    config.write_text(yaml.safe_dump({"name": name, "stop_time": LONG, **data}), encoding="utf-8")
    spec.write_text(json.dumps(_spec(prepare_to_run(config))), encoding="utf-8")
    return Case(name, config, spec)


def _typed(value: float, kind: Kind) -> float | int | bool:
    return {Kind.REAL: float, Kind.INTEGER: int, Kind.BOOLEAN: bool}[kind](value)


def _spec(experiment: Experiment) -> dict:
    instances = experiment.system.instances
    return {
        "step_size": experiment.config.step_size,
        "order": [list(members) for members in experiment.schedule.members],
        "fmus": {
            name: {
                "path": str(i.description.path),
                "start": {v: _typed(x, i.description.by_name[v].kind) for v, x in i.start.items()},
                "references": {v.name: v.reference for v in i.description.variables},
                "kinds": {v.name: v.kind.value for v in i.description.variables},
                "outputs": [v.name for v in i.description.outputs],
                "identifier": i.description.model_identifier,
                "token": i.description.token,
            }
            for name, i in instances.items()
        },
        "connections": [[w.source.name, w.target.name] for w in experiment.system.wires],
    }
