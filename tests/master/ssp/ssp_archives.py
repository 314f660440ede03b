"""Small SSP archives, written out: FMUs of a description alone, a structure, files next to it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

NAMESPACES = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in {
        "ssc": "Common",
        "ssd": "Description",
        "ssv": "ParameterValues",
        "ssm": "ParameterMapping",
        "ssb": "SignalDictionary",
    }.items()
)
EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="0.01"/>'
UNITS = """<ssd:Units>
  <ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>
  <ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit>
  <ssc:Unit name="km"><ssc:BaseUnit m="1" factor="1000"/></ssc:Unit>
  <ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit>
  <ssc:Unit name="kelvin"><ssc:BaseUnit K="1"/></ssc:Unit>
  <ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit>
</ssd:Units>"""
ENUMERATIONS = """<ssd:Enumerations>
  <ssc:Enumeration name="gear"><ssc:Item name="slow" value="1"/><ssc:Item name="fast" value="2"/></ssc:Enumeration>
</ssd:Enumerations>"""

# inputs and outputs of every type, and a parameter of each
BOX = {
    "u": ("input", '<Real unit="m" start="0"/>'),
    "y": ("output", '<Real unit="m"/>'),
    "bare": ("input", '<Real start="0"/>'),
    "bare_y": ("output", "<Real/>"),
    "f": ("input", '<Real unit="N" start="0"/>'),
    "i": ("input", '<Integer start="0"/>'),
    "i_y": ("output", "<Integer/>"),
    "b": ("input", '<Boolean start="false"/>'),
    "b_y": ("output", "<Boolean/>"),
    "e": ("input", '<Enumeration declaredType="gear" start="1"/>'),
    "e_y": ("output", '<Enumeration declaredType="gear"/>'),
    "w": ("input", '<Enumeration declaredType="way" start="1"/>'),
    "p": ("parameter", '<Real unit="m" start="0"/>'),
    "temperature": ("parameter", '<Real unit="K" start="0"/>'),
    "n": ("parameter", '<Integer start="0"/>'),
    "on": ("parameter", '<Boolean start="false"/>'),
    "mode": ("parameter", '<Enumeration declaredType="gear" start="1"/>'),
    "label": ("parameter", '<String start=""/>'),
    "k": ("calculatedParameter", "<Real/>"),
}
_KINDS = {
    "Real": "<ssc:Real{unit}/>",
    "Integer": "<ssc:Integer/>",
    "Boolean": "<ssc:Boolean/>",
    "Enumeration": '<ssc:Enumeration name="gear"/>',
    "String": "<ssc:String/>",
}


def fmu(variables: Mapping[str, tuple[str, str]] = BOX, kind: str = "CoSimulation") -> bytes:
    """An FMU 2.0 that has a description and no binary."""
    lines = []
    for i, (name, (causality, content)) in enumerate(variables.items()):
        variability = "continuous" if "<Real" in content else "discrete"
        initial = ""
        if causality == "parameter":
            variability = "fixed"
        if causality == "calculatedParameter":
            variability, initial = "fixed", 'initial="calculated"'
        lines.append(
            f'<ScalarVariable name="{name}" valueReference="{i}" causality="{causality}" '
            f'variability="{variability}" {initial}>{content}</ScalarVariable>'
        )
    outputs = [i for i, (causality, _) in enumerate(variables.values(), 1) if causality == "output"]
    unknowns = "".join(f'<Unknown index="{i}" dependencies=""/>' for i in outputs)
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="box" guid="g">
  <{kind} modelIdentifier="box"/>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1"/></Unit><Unit name="K"><BaseUnit K="1"/></Unit>
    <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="gear"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="2"/></Enumeration></SimpleType>
    <SimpleType name="way"><Enumeration><Item name="back" value="1"/><Item name="slow" value="7"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <ModelVariables>{"".join(lines)}</ModelVariables>
  <ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure>
</fmiModelDescription>"""
    return packed({"modelDescription.xml": text})


def packed(files: Mapping[str, str | bytes]) -> bytes:
    """A zip archive."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def connector(name: str, kind: str, type_: str = "", unit: str = "") -> str:
    """A connector; `type_` is a name such as Real, or empty for none."""
    unit = f' unit="{unit}"' if unit else ""
    inner = _KINDS[type_].format(unit=unit) if type_ else ""
    return f'<ssd:Connector name="{name}" kind="{kind}">{inner}</ssd:Connector>'


def connectors(*inner: str) -> str:
    """All connectors of an element."""
    return f"<ssd:Connectors>{''.join(inner)}</ssd:Connectors>" if inner else ""


def component(
    name: str,
    *more: str,
    ports: tuple[str, ...] | None = None,
    source: str = "resources/box.fmu",
    attributes: str = "",
) -> str:
    """A box with connectors for all that it has, or for `ports` alone as they are written."""
    inner = ports
    if inner is None:
        inner = tuple(connector(name, causality) for name, (causality, _) in BOX.items())
    return (
        f'<ssd:Component name="{name}" source="{source}" {attributes}>'
        f"{connectors(*inner)}{''.join(more)}</ssd:Component>"
    )


def link(start: str, end: str, inner: str = "", attributes: str = "") -> str:
    """A connection from `element.connector`, or `.connector` of the system, to another."""
    ends = []
    for side, text in (("start", start), ("end", end)):
        element, _, name = text.partition(".")
        ends.append(f'{side}Element="{element}" ' if element else "")
        ends.append(f'{side}Connector="{name}" ')
    return f"<ssd:Connection {''.join(ends)}{attributes}>{inner}</ssd:Connection>"


def links(*inner: str) -> str:
    """All connections of a system."""
    return f"<ssd:Connections>{''.join(inner)}</ssd:Connections>" if inner else ""


def parameter_set(*parameters: str, more: str = "", namespaces: str = "") -> str:
    """A parameter set."""
    return (
        f'<ssv:ParameterSet version="1.0" name="p" {namespaces}><ssv:Parameters>'
        f"{''.join(parameters)}</ssv:Parameters>{more}</ssv:ParameterSet>"
    )


def parameter(name: str, type_: str, value: str, more: str = "") -> str:
    """One value."""
    return f'<ssv:Parameter name="{name}"><ssv:{type_} value="{value}" {more}/></ssv:Parameter>'


def mapping(*entries: str, namespaces: str = "") -> str:
    """A parameter mapping."""
    return f'<ssm:ParameterMapping version="1.0" {namespaces}>{"".join(entries)}</ssm:ParameterMapping>'


def entry(source: str, target: str, inner: str = "", attributes: str = "") -> str:
    """One entry of a mapping."""
    return f'<ssm:MappingEntry source="{source}" target="{target}" {attributes}>{inner}</ssm:MappingEntry>'


def binding(content: str = "", renaming: str = "", attributes: str = "") -> str:
    """One binding, with values inside or by its `source`."""
    values = f"<ssd:ParameterValues>{content}</ssd:ParameterValues>" if content else ""
    mapped = f"<ssd:ParameterMapping>{renaming}</ssd:ParameterMapping>" if renaming else ""
    return f"<ssd:ParameterBinding {attributes}>{values}{mapped}</ssd:ParameterBinding>"


def bindings(*inner: str) -> str:
    """All bindings of an element."""
    return f"<ssd:ParameterBindings>{''.join(inner)}</ssd:ParameterBindings>"


def system(
    *elements: str, before: str = "", after: str = "", name: str = "root", attributes: str = ""
) -> str:
    """A system."""
    return (
        f'<ssd:System name="{name}" {attributes}>{before}<ssd:Elements>{"".join(elements)}</ssd:Elements>'
        f"{after}</ssd:System>"
    )


def structure(content: str, *, version: str = "1.0", more: str = ENUMERATIONS + UNITS + EXPERIMENT) -> str:
    """A structure file."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<ssd:SystemStructureDescription {NAMESPACES} version="{version}" name="s">\n'
        f"{content}{more}</ssd:SystemStructureDescription>"
    )


def write(
    folder: Path, content: str, files: Mapping[str, str | bytes] | None = None, name: str = "s.ssp"
) -> Path:
    """An archive with a structure, the box and further files."""
    text = content if content.startswith("<?xml") else structure(content)
    everything = {"SystemStructure.ssd": text, "resources/box.fmu": fmu(), **(files or {})}
    path = folder / name
    path.write_bytes(packed(everything))
    return path
