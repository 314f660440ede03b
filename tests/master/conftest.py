"""Systems in YAML whose FMUs are stubs: the files exist and are empty, their content comes from here."""

from __future__ import annotations

import functools
import importlib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from master.errors import ConfigError
from master.experiment import prepare as preparation
from master.fmi.description import Kind
from master.stepping import simulate
from tests.stubs import (
    CELSIUS,
    ERROR,
    KELVIN,
    METRE,
    NEWTON,
    Stub,
    calling,
    clock,
    failing,
    gain,
    growing,
    integrator,
    typed,
    variables,
)

CHOICE = {"kind": Kind.INTEGER, "variability": "fixed", "items": {"first": 1, "second": 2}, "start": "1"}
BOUNDED = {"minimum": 0.0, "maximum": 10.0, "unit": METRE, "variability": "tunable"}


def with_parameters(block):
    """Add a parameter of every kind."""
    more = variables(
        ("size", "parameter", BOUNDED),
        ("choice", "parameter", CHOICE),
        ("on", "parameter", {"kind": Kind.BOOLEAN, "variability": "fixed"}),
        ("count", "parameter", {"kind": Kind.INTEGER, "variability": "fixed"}),
        ("label", "parameter", {"kind": Kind.STRING, "variability": "fixed", "start": ""}),
    )
    n = len(block.variables)
    return replace(
        block, variables=block.variables + tuple(replace(v, reference=v.reference + n) for v in more)
    )


def blocks(interrupt):
    return {
        "clock": clock(),
        "gain": gain(),
        "adding": replace(gain(), law=lambda t, h, v: {"y": v["u"] + 1.0}),
        "integrator": with_parameters(integrator(METRE)),
        "growing": growing(2.0),
        "failing": failing(3.0, ERROR, "rope torn"),
        "interrupting": calling(lambda t: interrupt() if t == 10.0 else None),
        "typed": typed(),
        "celsius": gain(source=CELSIUS),
        "kelvin": gain(source=KELVIN, target=KELVIN),
        "newton": gain(source=NEWTON, target=NEWTON),
        "metre": gain(source=METRE, target=METRE),
    }


@pytest.fixture
def bay(tmp_path, monkeypatch):
    """A folder with stub FMUs; `write` puts a system.yaml there, `faults` gives all that is wrong with it."""
    space = SimpleNamespace(folder=tmp_path, interrupt=lambda: None, slaves={})
    made = blocks(lambda: space.interrupt())
    for name in made:
        (tmp_path / f"{name}.fmu").touch()

    def factory(name, description):
        space.slaves[name] = Stub(name, description, made[description.model_name].law)
        return space.slaves[name]

    read = preparation.read_description
    monkeypatch.setattr(
        preparation,
        "read_description",
        lambda path: made[path.stem].description(path.stem) if path.stem in made else read(path),
    )
    stub_needs_no_binary = importlib.import_module("master.fmi.unpacked")
    monkeypatch.setattr(stub_needs_no_binary, "require_runnable", lambda descriptions: None)
    for function in ("simulate", "running"):
        made_with = functools.partial(getattr(simulate, function), factory=factory)
        monkeypatch.setattr(simulate, function, made_with)

    def write(text: str) -> Path:
        path = tmp_path / "system.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    def faults(text: str, **request) -> list[str]:
        with pytest.raises(ConfigError) as caught:
            preparation.prepare(write(text), preparation.Request(**request))
        return [p.replace(f"{tmp_path}/", "") for p in caught.value.problems]

    space.write, space.faults, space.factory, space.made = write, faults, factory, made
    return space
