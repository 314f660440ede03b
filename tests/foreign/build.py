"""Small FMUs of the tests: C compiled on the spot, a description written out, functions that FMPy binds."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
FOLDERS = {"2.0": "linux64", "3.0": "x86_64-linux"}
TYPES_3 = (
    *("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"),
    "Boolean",
)
ARRAYS = (
    ("Float64", "a", 100, 'causality="input" start="1 2 3 4 5 6"', (2, 3)),
    ("Float64", "b", 101, 'causality="output"', (2, 3)),
    ("Int32", "ia", 110, 'causality="input" start="0"', (2,)),
    ("Int32", "ib", 111, 'causality="output"', (2,)),
    ("Boolean", "ba", 112, 'causality="input" start="false false"', (2,)),
    ("Boolean", "bb", 113, 'causality="output"', (2,)),
)


def compile_c(version: str, folder: Path, file: Path | None = None, *options: str) -> bytes:
    """Compile an FMU's C file; what FMPy binds and the file lacks answers with an error."""
    number = version[0]
    source = (file or HERE / f"types{number}.c").read_text(encoding="utf-8")
    has = set(re.findall(rf"\bfmi{number}\w+", source))
    has |= {
        f"fmi{number}{verb}{name}"
        for verb in ("Set", "Get")
        for name in re.findall(r"^TYPE\((\w+)", source, re.M)
    }
    binding = Path(importlib.util.find_spec("fmpy").origin).with_name(f"fmi{number}.py")
    wanted = set(re.findall(rf"""['"](fmi{number}[A-Z]\w+)['"]""", binding.read_text(encoding="utf-8")))
    missing = sorted(wanted - has)
    completed, library = folder / f"fmu{number}.c", folder / f"fmu{number}.so"
    completed.write_text(source + "".join(f"\nint {name}(void) {{ return 3; }}" for name in missing) + "\n")
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, completed, *options], check=True)
    return library.read_bytes()


def write_fmu(path: Path, description: str, binaries: dict[str, bytes]) -> Path:
    """Pack an FMU."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        for name, content in binaries.items():
            archive.writestr(f"binaries/{name}", content)
    return path


def _array(kind: str, name: str, reference: int, more: str, shape: tuple[int, ...]) -> str:
    dimensions = "".join(f'<Dimension start="{n}"/>' for n in shape)
    return f'<{kind} name="{name}" valueReference="{reference}" {more}>{dimensions}</{kind}>'


def describe_3(
    interface: str = '<CoSimulation modelIdentifier="types"/>', more: str = "", token: str = "types"
) -> str:
    """Write the description of the FMU 3.0."""
    variables, fixed = [], 'causality="parameter" variability="fixed"'
    for i, name in enumerate(TYPES_3):
        start = "false" if name == "Boolean" else "0"
        common = f'variability="{"continuous" if name.startswith("Float") else "discrete"}"'
        variables.append(
            f'<{name} name="{name}_in" valueReference="{2 * i}" causality="input" start="{start}" {common}/>'
        )
        variables.append(
            f'<{name} name="{name}_out" valueReference="{2 * i + 1}" causality="output" {common}/>'
        )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="types" instantiationToken="{token}">
  {interface}
  <ModelVariables>
    <Float64 name="time" valueReference="999" causality="independent" variability="continuous"/>
    {"".join(variables)}
    {"".join(_array(*a) for a in ARRAYS)}
    <Int32 name="answer" valueReference="120" {fixed} start="0"/>
    <String name="label" valueReference="121" {fixed}><Start value=""/></String>
    {more}
  </ModelVariables>
  <ModelStructure><Output valueReference="101"/></ModelStructure>
</fmiModelDescription>
"""


def describe_2(interface: str = '<CoSimulation modelIdentifier="types"/>', version: str = "2.0") -> str:
    """Write the description of the FMU 2.0."""
    ports = [("Real", "", 0, "0"), ("Integer", "", 0, "0"), ("Enumeration", ' declaredType="Gear"', 2, "1")]
    variables = []
    for name, declared, first, start in [*ports, ("Boolean", "", 0, "false")]:
        variability = "continuous" if name == "Real" else "discrete"
        for i, (end, causality) in enumerate((("in", "input"), ("out", "output"))):
            value = f' start="{start}"' if end == "in" else ""
            variables.append(
                f'<ScalarVariable name="{name}_{end}" valueReference="{first + i}" causality="{causality}" '
                f'variability="{variability}"><{name}{declared}{value}/></ScalarVariable>'
            )
    fixed = 'causality="parameter" variability="fixed"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="types" guid="types">
  {interface}
  <TypeDefinitions><SimpleType name="Gear"><Enumeration>
    <Item name="low" value="1"/><Item name="high" value="2"/>
  </Enumeration></SimpleType></TypeDefinitions>
  <ModelVariables>
    {"".join(variables)}
    <ScalarVariable name="answer" valueReference="120" {fixed}><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="label" valueReference="121" {fixed}><String start=""/></ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""
