"""A configuration with another method in the place of its compensator, and a cell's changes."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

from master import catalogue
from master.errors import ConfigError
from master.system.config import load_config
from master.text.yaml_lines import read_yaml

from .cells import Cell
from .methods import PAPER, Method

SPACECRAFT = "spacecraft"
PLANT = "motion_simulator_linear"
SENSOR = "force_sensor"
DISPLACEMENT_SENSOR = "displacement_sensor"
NOISE_SEED = 1_000_000
"""Added to the seed of the force, for the noise of the displacement."""


class Base:
    """A configuration as written, with the instances that a comparison needs."""

    def __init__(self, path: Path) -> None:
        """Read it; ConfigError with every fault, or if it is no docking loop that can be compared."""
        load_config(path)
        self.path = path
        self.name = path.stem
        self.document: dict[str, Any] = read_yaml(path).data
        roles = {"compensator": PAPER, "spacecraft": SPACECRAFT, "plant": PLANT, "sensor": SENSOR}
        found = {role: self._instance(source) for role, source in roles.items()}
        compare = self.document.get("compare") or {}
        problems = [f"{path}: fmus: no instance of {roles[role]}" for role, name in found.items() if not name]
        problems += [
            f"{path}: compare.{key}: missing, expected a signal"
            for key in ("signal", "reproduced", "reference")
            if not compare.get(key)
        ]
        if problems:
            raise ConfigError(problems)
        self.compensator, self.spacecraft, self.plant, self.sensor = (str(name) for name in found.values())

    def _instance(self, source: str) -> str | None:
        fmus = self.document["fmus"].items()
        return next((name for name, entry in fmus if entry["source"] == source), None)

    def value(self, instance: str, name: str) -> float:
        """Return a parameter as written, or as the model has it; KeyError if there is none."""
        entry = self.document["fmus"][instance]
        given = (entry.get("parameters") or {}).get(name)
        if given is not None:
            return float(given)
        return catalogue.parameters(entry["source"])[name]

    def beliefs(self, cell: Cell) -> dict[str, float]:
        """
        Return all that methods may be told, by the names of their parameters.

        It is the configuration without the changes of the cell, times the factors of the cell's prior.
        """
        k, c, lag = cell.prior.k, cell.prior.c, cell.prior.lag
        contact = {n: self.value(self.compensator, n) for n in ("m_e", "k_m", "c_m", "k_p", "c_p")}
        contact |= {n: k * contact[n] for n in ("k_m", "k_p")} | {n: c * contact[n] for n in ("c_m", "c_p")}
        k_m, k_p = contact["k_m"], contact["k_p"]
        stiffness = k_m * k_p / (k_m + k_p)
        loss = contact["c_m"] / k_m + contact["c_p"] / k_p - (contact["c_m"] + contact["c_p"]) / (k_m + k_p)
        plant = {n: self.value(self.plant, n) for n in ("K_p", "w_v", "z", "dead_time")}
        plant |= {n: plant[n] / lag for n in ("K_p", "w_v")}
        T_f = cell.prior.T_f * self.value(self.sensor, "T_f")
        late = 1.0 / plant["K_p"] + plant["dead_time"] + 0.5 * float(self.document["step_size"])
        others = {
            "m_s": self.value(self.spacecraft, "m_s"),
            "T_f_hat": T_f,
            "stiffness": stiffness,
            "damping": stiffness * loss,
            "lag": late,
            "latency": late + T_f,
        }
        return {**contact, **plant, **others}


def system(base: Base, cell: Cell, method: Method, seed: int) -> dict[str, Any]:
    """
    Return the document of a system: the method, the cell's changes, the seed, leapfrog.

    Raises:
        ConfigError: If the cell names what the configuration has not.
    """
    made = copy.deepcopy(base.document)
    made.pop("variants", None)
    fmus = made["fmus"]
    put_method(made, base, cell, method)
    for instance, source in cell.laws.items():
        if instance not in fmus:
            raise ConfigError(
                [f"laws.{instance}: no such instance, got {instance!r}, expected {sorted(fmus)}"]
            )
        fmus[instance]["source"] = source
    _parameters(fmus[base.spacecraft])["integrator"] = "leapfrog"
    for signal, value in cell.set.items():
        instance, _, name = signal.partition(".")
        if instance not in fmus:
            raise ConfigError([f"set.{signal}: no such instance, got {instance!r}, expected {sorted(fmus)}"])
        _parameters(fmus[instance])[name] = _number(base, signal, value)
    if cell.events:
        seeded = [{**event, "seed": seed} if "jitter" in event else event for event in cell.events]
        made["events"] = [*(made.get("events") or []), *seeded]
    if cell.s_act_noise > 0.0:
        _put_noise(made, base, cell.s_act_noise)
    for signal, value in seeds(base, cell, seed).items():
        instance, _, name = signal.partition(".")
        _parameters(fmus[instance])[name] = value
    if cell.stop_time is not None:
        made["stop_time"] = cell.stop_time
    return dict(made)


def seeds(base: Base, cell: Cell, seed: int) -> dict[str, int]:
    """Return the seeds of the instances that make noise, `instance.variable` to value."""
    found = {f"{base.sensor}.seed": seed}
    if cell.s_act_noise > 0.0:
        found[f"{DISPLACEMENT_SENSOR}.seed"] = NOISE_SEED + seed
    return found


def _parameters(entry: dict[str, Any]) -> dict[str, Any]:
    if entry.get("parameters") is None:
        entry["parameters"] = {}
    found: dict[str, Any] = entry["parameters"]
    return found


def put_method(made: dict[str, Any], base: Base, cell: Cell, method: Method) -> None:
    """Let a method take the place of the compensator in a document, told what the cell lets it believe."""
    own = _parameters(made["fmus"][base.compensator]) if method.model == PAPER else {}
    takes = method.takes()
    told = {n: v for n, v in {**base.beliefs(cell), **cell.told}.items() if n in takes}
    values = {**own, **told, **method.values}
    if method.model == PAPER:
        values["fmdc"] = told["T_f_hat"] > 0.0
    made["fmus"][base.compensator] = {"source": method.model, "parameters": values}
    old, new = f"{base.compensator}.f_des", f"{base.compensator}.f_comp"
    for wire in made["connections"]:
        wire["from"] = new if wire["from"] == old else wire["from"]
    made["connections"].append(
        {"from": f"{base.spacecraft}.v_des", "to": f"{base.compensator}.v_des"},
    )
    made["compare"] = {k: new if v == old else v for k, v in made["compare"].items()}


def _put_noise(made: dict[str, Any], base: Base, sigma: float) -> None:
    """Put white noise between the displacement and the compensator: a force sensor without lag makes it."""
    name = DISPLACEMENT_SENSOR
    made["fmus"][name] = {"source": SENSOR, "parameters": {"T_f": 0.0, "sigma": sigma}}
    measured = f"{base.plant}.s_act"
    for wire in list(made["connections"]):
        if wire["from"] == measured and wire["to"] == f"{base.compensator}.s_act":
            made["connections"].remove(wire)
            made["connections"] += [
                {"from": measured, "to": f"{name}.f_act", "units": "ignored"},
                {"from": f"{name}.f_mea", "to": wire["to"], "units": "ignored"},
            ]
    order = made["coupling"]["order"]
    order.insert(order.index(base.plant) + 1, name)


def _number(base: Base, signal: str, value: float | str) -> float:
    try:
        return float(value)
    except ValueError:
        pass
    factor, _, source = str(value).partition(" ")
    instance, _, name = source.strip().partition(".")
    try:
        found = float(factor) * base.value(instance, name)
    except (ValueError, KeyError):
        found = math.nan
    if not math.isfinite(found):
        raise ConfigError(
            [f"set.{signal}: not a value, got {value!r}, expected a number or FACTOR instance.parameter"]
        )
    return found
