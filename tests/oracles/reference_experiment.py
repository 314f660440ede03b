"""A reference experiment as the files that an FMU carries: parameters (SSV), inputs and outputs (CSV)."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


@dataclass(frozen=True)
class Experiment:
    """Parameters and start values, inputs and expected outputs on one time grid [s]."""

    model: str
    time: np.ndarray
    parameters: Mapping[str, float | int | bool]
    inputs: Mapping[str, np.ndarray]
    outputs: Mapping[str, np.ndarray]

    def files(self) -> dict[str, bytes]:
        """Name to content."""
        return {
            f"{self.model}_in.csv": table(self.time, self.inputs),
            f"{self.model}_out.csv": table(self.time, self.outputs),
            f"{self.model}.ssv": parameter_set(self.model, self.parameters),
        }


def time_grid(n_steps: int, step: float) -> np.ndarray:
    """Give t_k = k h, each rounded once from its decimal form."""
    return np.array([round(k * step, 9) for k in range(n_steps + 1)])


def table(time: np.ndarray, columns: Mapping[str, np.ndarray]) -> bytes:
    """Write a CSV as FMPy reads it, every number exact."""
    text = io.StringIO()
    text.write(",".join(f'"{name}"' for name in ("time", *columns)) + "\n")
    for row in zip(time, *columns.values(), strict=True):
        text.write(",".join(shortest(float(value)) for value in row) + "\n")
    return text.getvalue().encode()


def shortest(value: float) -> str:
    """Write a number as short as its value allows; no negative zero."""
    text = repr(value + 0.0)
    return text[:-2] if text.endswith(".0") else text


def parameter_set(name: str, values: Mapping[str, float | int | bool]) -> bytes:
    """Write SSP 1.0 parameter values."""
    ET.register_namespace("ssv", SSV)
    root = ET.Element(f"{{{SSV}}}ParameterSet", version="1.0", name=name)
    parameters = ET.SubElement(root, f"{{{SSV}}}Parameters")
    for key, value in values.items():
        parameter = ET.SubElement(parameters, f"{{{SSV}}}Parameter", name=key)
        kind = "Boolean" if isinstance(value, bool) else "Integer" if isinstance(value, int) else "Real"
        ET.SubElement(
            parameter, f"{{{SSV}}}{kind}", value=str(value).lower() if kind == "Boolean" else repr(value)
        )
    ET.indent(root)
    content: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return content + b"\n"
