"""FMUs of both versions that do a deed in a call of one's choice, and the system that they are in."""

from __future__ import annotations

from enum import IntEnum
from pathlib import Path

from .build import FOLDERS, HERE, compile_c, write_fmu


class Deed(IntEnum):
    """What the FMU does."""

    NOTHING = 0
    SEGFAULT = 1
    ABORT = 2
    EXIT = 3
    HANG = 4
    EAT = 5
    MOVE = 6
    ROUND = 7
    ERROR = 8
    SAY = 9
    WRITE = 10
    CONNECT = 11
    CHATTER = 12
    COUNT_ALOUD = 13


class When(IntEnum):
    """In which call."""

    STEP = 0
    SET = 1
    GET = 2
    ENTER = 3
    EXIT = 4
    SAVE = 5
    END = 6


_PORTS = (
    ("x", 0, "output", "continuous", "Real"),
    ("y", 1, "output", "continuous", "Real"),
    ("n", 2, "output", "discrete", "Integer"),
    ("count", 3, "output", "discrete", "Integer"),
    ("deed", 8, "parameter", "fixed", "Integer"),
    ("when", 9, "parameter", "fixed", "Integer"),
    ("first", 10, "parameter", "fixed", "Integer"),
    ("input", 11, "input", "continuous", "Real"),
)
_NAMES_3 = {"Real": "Float64", "Integer": "Int32"}

SYSTEM = """\
name: faulty
step_size: 0.001
stop_time: {stop}
fmus:
  faulty:
    {{source: faulty{version}.fmu, parameters: {{deed: {deed:d}, when: {when:d}, first: {first}}}{more}}}
  other: {{source: faulty{version}.fmu}}
coupling: {{order: {order}}}
connections:
  - {{from: faulty.x, to: other.input}}
  - {{from: other.x, to: faulty.input}}
"""


def describe(version: str) -> str:
    """Write the description of either version."""
    variables = []
    for name, reference, causality, variability, kind in _PORTS:
        start = "" if causality == "output" else ' start="0"'
        common = (
            f'name="{name}" valueReference="{reference}" causality="{causality}" variability="{variability}"'
        )
        if version == "2.0":
            variables.append(f"<ScalarVariable {common}><{kind}{start}/></ScalarVariable>")
        else:
            variables.append(f"<{_NAMES_3[kind]} {common}{start}/>")
    token = "guid" if version == "2.0" else "instantiationToken"
    saves = "canGetAndSetFMUstate" if version == "2.0" else "canGetAndSetFMUState"
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="faulty" {token}="faulty">
  <CoSimulation modelIdentifier="faulty" {saves}="true"/>
  <ModelVariables>{"".join(variables)}</ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""


def build(folder: Path) -> None:
    """Write `faulty2.fmu` and `faulty3.fmu`."""
    for version, option in (("2.0", "-DTWO"), ("3.0", "-DTHREE")):
        library = compile_c(version, folder, HERE / "faulty.c", option, "-lm", "-w")
        name = f"faulty{version[0]}.fmu"
        write_fmu(folder / name, describe(version), {f"{FOLDERS[version]}/faulty.so": library})
