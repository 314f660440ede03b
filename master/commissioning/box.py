"""
The box of what is not known of a rig: factors on its parameters, which those who believe them do not see.

    box:
      stiffness: {multiplies: [contact.k_m, contact.k_p], from: 0.8, to: 1.2}
      lag: {divides: [motion_simulator.K_p, motion_simulator.w_v], from: 0.8, to: 1.2}
    points: 3
    force_path: force_sensor.f_act
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from master import catalogue
from master.errors import ConfigError, Problem, nearest
from master.fmi.description import Kind
from master.system.config import Config
from master.system.graph import System
from master.text.fields import Integer, Positive, Section, Signal
from master.text.signal_name import SignalName
from master.text.validation import validated
from master.text.yaml_lines import read_yaml

CONTACT = "docking_contact"
PLANT = "motion_simulator_linear"
SENSOR = "force_sensor"
MOST_POINTS = 20_000
"""Plants that one box may have."""


class Unknown(Section):
    """A factor from `from` to `to` that multiplies some parameters and divides others."""

    multiplies: list[Signal] = Field(default=[])
    divides: list[Signal] = Field(default=[])
    from_: Positive = Field(alias="from", examples=[0.8])
    to: Positive = Field(examples=[1.2])

    @model_validator(mode="after")
    def _has_a_range(self) -> Unknown:
        if not self.multiplies and not self.divides:
            raise ValueError("acts on nothing, expected parameters in 'multiplies' or 'divides'")
        if not self.from_ < self.to:
            raise ValueError(f"no range, got from {self.from_:g} to {self.to:g}, expected from below to")
        return self

    def values(self, points: int) -> NDArray[np.float64]:
        """Return the factors at which the box is looked at, both ends among them."""
        return np.linspace(self.from_, self.to, points)

    def changes(self, factor: float, own: Mapping[str, float]) -> Iterator[tuple[str, float]]:
        """Return the parameters with a factor."""
        for signal in self.multiplies:
            yield signal, own[signal] * factor
        for signal in self.divides:
            yield signal, own[signal] / factor


class Box(Section):
    """All that is not known, each with its range; every combination of their points is a plant."""

    box: Annotated[dict[str, Unknown], Field(min_length=1)]
    points: Annotated[Integer, Field(ge=2, le=101)] = 3
    force_path: Signal | None = None

    @field_validator("box")
    @classmethod
    def _few_enough(cls, box: dict[str, Unknown]) -> dict[str, Unknown]:
        if 2 ** len(box) > MOST_POINTS:
            raise ValueError(f"{len(box)} unknowns have more than {MOST_POINTS} corners, expected fewer")
        return box

    @property
    def n_plants(self) -> int:
        """Number of combinations."""
        return int(self.points ** len(self.box))


def read_box(path: Path) -> Box:
    """
    Read a box.

    Raises:
        ConfigError: With every fault of the file.
    """
    return validated(Box, read_yaml(path), "box")


def default_box(config: Config) -> Box:
    """
    Return stiffness +-20 %, damping +-30 % and lag +-20 % of the contact and the motion simulator.

    Raises:
        ConfigError: If the system has neither.
    """
    contact = instance_of(config, CONTACT)
    plant = instance_of(config, PLANT)
    found: dict[str, Unknown] = {}
    if contact is not None:
        stiffness = [SignalName(f"{contact}.{name}") for name in ("k_m", "k_p")]
        damping = [SignalName(f"{contact}.{name}") for name in ("c_m", "c_p")]
        found["stiffness"] = Unknown.model_validate({"multiplies": stiffness, "from": 0.8, "to": 1.2})
        found["damping"] = Unknown.model_validate({"multiplies": damping, "from": 0.7, "to": 1.3})
    if plant is not None:
        lag = [SignalName(f"{plant}.{name}") for name in ("K_p", "w_v")]
        found["lag"] = Unknown.model_validate({"divides": lag, "from": 0.8, "to": 1.2})
    if not found:
        what = f"no FMU of {CONTACT} or {PLANT} that a box could be about"
        raise ConfigError([Problem(what, where="fmus", expected="--box with parameters of this system")])
    return Box(box=found)


def instance_of(config: Config, model: str) -> str | None:
    """Name the first FMU of a model, with effects or without."""
    entries = config.fmus.items()
    return next((name for name, entry in entries if catalogue.base_model(entry.source) == model), None)


def own_values(box: Box, system: System) -> dict[str, float]:
    """
    Return the values of all parameters of a box as the system has them.

    Raises:
        ConfigError: With every one that is no real parameter, or has no value that a factor changes.
    """
    problems = []
    found: dict[str, float] = {}
    for name, unknown in box.box.items():
        for signal in (*unknown.multiplies, *unknown.divides):
            where = f"box.{name}"
            instance, variable = SignalName(signal).parts
            known = system.descriptions.get(instance)
            parameters = [
                f"{instance}.{v.name}"
                for v in (() if known is None else known.variables)
                if v.causality == "parameter" and v.kind is Kind.REAL
            ]
            if signal not in parameters:
                expected = nearest(signal, parameters or system.instances)
                problems.append(
                    Problem("no such real parameter", where=where, got=repr(str(signal)), expected=expected)
                )
                continue
            value = float(system.instances[instance].value_of(variable) or 0.0)
            if value == 0.0:
                problems.append(
                    Problem(f"{signal} is 0", where=where, expected="a value that a factor changes")
                )
            elif signal in found:
                problems.append(
                    Problem(f"{signal} is named twice", where=where, expected="one factor for it")
                )
            found[signal] = value
    if box.n_plants > MOST_POINTS:
        got = f"{box.points} points for each of {len(box.box)} unknowns, {box.n_plants}"
        problems.append(
            Problem("too many plants", where="points", got=got, expected=f"at most {MOST_POINTS}")
        )
    if problems:
        raise ConfigError(problems)
    return found
