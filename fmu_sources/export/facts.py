"""What every model description says, whatever the FMI version: facts of a model and shared XML parts."""

from __future__ import annotations

import hashlib
import uuid
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from ..framework.model import Delay, Model
from ..framework.variables import Role, Variable
from .dependencies import influences
from .units import DISPLAY_UNITS, scale_of, si_exponents

TOOL = "dockloop"
DATE = "2026-01-01T00:00:00Z"
STEP_SIZE = 1e-3


@dataclass(frozen=True)
class Flavour:
    """What differs in the description between the ways of building an FMU."""

    name: str
    needs_execution_tool: bool
    once_per_process: bool = False
    directional_derivatives: bool = False


def guid(*contents: bytes) -> str:
    """Content hash in the form of a GUID."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return "{" + str(uuid.UUID(bytes=digest.digest()[:16])) + "}"


def fmi_variables(model: Model) -> list[tuple[int, Variable]]:
    """Variables that FMI shows, each with its value reference, its place in `model.all_variables`."""
    return [(i, v) for i, v in enumerate(model.all_variables) if not v.hidden]


def is_output(v: Variable) -> bool:
    """Whether the variable is an FMI output."""
    return v.role is Role.OUTPUT or v.output


def causality(v: Variable) -> str:
    """FMI causality."""
    if v.role in (Role.PARAMETER, Role.INPUT):
        return str(v.role.value)
    return "output" if is_output(v) else "local"


def variability(model: Model, v: Variable) -> str:
    """FMI variability."""
    if v.role is Role.PARAMETER:
        return "fixed" if v.fixed else "tunable"
    stepwise = v.sampled or v.boolean or (v.role is Role.OUTPUT and not model.n_continuous)
    return "discrete" if stepwise else "continuous"


def start_text(v: Variable) -> str:
    """Start value, exact to the last bit."""
    if v.boolean:
        return "true" if v.start else "false"
    return repr(int(v.start)) if v.integer else repr(float(v.start))


def used_units(model: Model) -> list[str]:
    """Units of all shown variables, each once, sorted."""
    return sorted({v.unit for _, v in fmi_variables(model) if not (v.integer or v.boolean)})


def document(root: ET.Element) -> bytes:
    """Serialise with two blanks of indentation."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def add_coupling_facts(parent: ET.Element, model: Model) -> None:
    """
    Write what a master cannot see from outside.

    Which inputs reach an output, own delays, values with which the model is linear, and when it learns.
    """
    coupling = ET.SubElement(parent, "Coupling")
    for name, inputs in influences(model).items():
        ET.SubElement(coupling, "Influence", output=name, inputs=" ".join(inputs))
    for delay in model.delays:
        _add_delay(coupling, delay)
    for linear in model.linear:
        element = ET.SubElement(
            coupling, "Linear", parameter=linear.parameter, value=str(linear.value), reason=linear.reason
        )
        if linear.frequency is not None:
            element.set("frequency", linear.frequency)
    for learning in model.learning:
        ET.SubElement(coupling, "Learning", by=learning.by, item=learning.item, held=learning.held_by)


def _add_delay(parent: ET.Element, delay: Delay) -> None:
    element = ET.SubElement(parent, "Delay", input=delay.input, kind=delay.kind, reason=delay.reason)
    element.set("seconds", str(delay.seconds))
    if isinstance(delay.steps, float | int):
        element.set("steps", str(delay.steps))
        return
    element.set("by", delay.by or "")
    for item, steps in delay.steps.items():
        ET.SubElement(element, "When", item=item, steps=str(steps))


def enumerations(model: Model) -> dict[str, Variable]:
    """Enumeration types by name, with one variable that has the type."""
    return {type_name(v): v for v in model.all_variables if v.items is not None}


def type_name(v: Variable) -> str:
    """Name of the type definition of an enumeration."""
    assert v.items is not None
    return v.items.__name__


def add_unit_definitions(root: ET.Element, model: Model) -> None:
    """Write the used units with their SI exponents and display units."""
    units = ET.SubElement(root, "UnitDefinitions")
    for name in used_units(model):
        unit = ET.SubElement(units, "Unit", name=name)
        ET.SubElement(unit, "BaseUnit", _base_unit(name))
        if name in DISPLAY_UNITS:
            shown, factor = DISPLAY_UNITS[name]
            ET.SubElement(unit, "DisplayUnit", name=shown, factor=repr(factor))


def _base_unit(name: str) -> dict[str, str]:
    """Attributes of a unit: its exponents, and factor and offset where they are not 1 and 0."""
    scale = scale_of(name)
    attributes = {base: str(exponent) for base, exponent in si_exponents(name).items()}
    if scale.factor != 1:
        attributes["factor"] = repr(float(scale.factor))
    if scale.offset != 0:
        attributes["offset"] = repr(float(scale.offset))
    return attributes


def add_log_categories(root: ET.Element) -> None:
    """Write the categories that messages carry."""
    categories = ET.SubElement(root, "LogCategories")
    for name in ("logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logAll"):
        ET.SubElement(categories, "Category", name=name)


def bounds(v: Variable, number: type[int] | type[float]) -> dict[str, str]:
    """Attributes min, max and nominal, where the declaration has them."""
    low = v.above if v.minimum is None else v.minimum
    pairs = (("min", low), ("max", v.maximum), ("nominal", v.nominal))
    return {key: repr(number(value)) for key, value in pairs if value is not None}
