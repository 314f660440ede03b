"""terminalsAndIcons of FMI 3.0: the plugs that a model declares, and its icon."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from ..framework.model import Model
from .facts import document
from .icon import icon_png


def terminal_files(model: Model) -> dict[str, bytes]:
    """Path in the FMU to content."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    icon = ET.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    ET.SubElement(icon, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    ET.SubElement(icon, "Icon", corners)
    if model.terminals:
        terminals = ET.SubElement(root, "Terminals")
    for terminal in model.terminals:
        element = ET.SubElement(
            terminals,
            "Terminal",
            name=terminal.name,
            matchingRule="plug",
            terminalKind=f"org.dockloop.{terminal.kind}",
            description=terminal.description,
        )
        for member, variable in terminal.members.items():
            ET.SubElement(
                element,
                "TerminalMemberVariable",
                variableName=variable,
                memberName=member,
                variableKind="signal",
            )
    return {
        "terminalsAndIcons/terminalsAndIcons.xml": document(root),
        "terminalsAndIcons/icon.png": icon_png(model.name),
    }
