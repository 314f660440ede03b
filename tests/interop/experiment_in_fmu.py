"""The reference experiment as it stands inside an FMU: found through its manifest, nothing else known."""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
from fmpy import read_model_description, simulate_fmu

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
BOUND = 1e-12
CAST = {"Real": float, "Integer": int, "Boolean": lambda text: text == "true"}


@dataclass(frozen=True)
class Vectors:
    """Parameters, inputs and expected outputs, each table with a column `time`."""

    fmu: Path
    parameters: dict[str, float | int | bool]
    inputs: np.ndarray
    outputs: np.ndarray
    step: float

    @property
    def input_names(self) -> list[str]:
        return list(self.inputs.dtype.names[1:])

    @property
    def output_names(self) -> list[str]:
        return list(self.outputs.dtype.names[1:])

    def rows(self) -> np.ndarray:
        """Inputs alone, shape (rows, inputs)."""
        return np.column_stack([self.inputs[name] for name in self.input_names])

    def as_json(self, path: Path) -> Path:
        """Write what a script in another environment needs."""
        content = {
            "parameters": self.parameters,
            "inputs": self.input_names,
            "outputs": self.output_names,
            "rows": self.rows().tolist(),
            "step": self.step,
        }
        path.write_text(json.dumps(content))
        return path

    def as_text(self, path: Path) -> Path:
        """Write what the plain C host reads."""
        variables = {v.name: v for v in read_model_description(self.fmu).modelVariables}
        kinds = {"Real": "r", "Float64": "r", "Boolean": "b", "Enumeration": "e"}
        sets = [
            f"{kinds.get(variables[n].type, 'i')} {variables[n].valueReference} {float(value)!r}"
            for n, value in self.parameters.items()
        ]
        references = [
            " ".join(str(variables[n].valueReference) for n in names)
            for names in (self.input_names, self.output_names)
        ]
        counts = (len(sets), len(self.input_names), len(self.output_names), len(self.inputs), self.step)
        rows = [" ".join(map(repr, row)) for row in self.rows().tolist()]
        path.write_text("\n".join([" ".join(map(str, counts)), *sets, *references, *rows, ""]))
        return path

    def largest_deviation(self, got: np.ndarray, first: int = 0) -> float:
        """Largest deviation from the expected outputs, relative to each one's largest value."""
        expected = np.column_stack([self.outputs[name] for name in self.output_names])
        assert np.shape(got) == expected[first:].shape
        return float(np.max(np.abs(got - expected[first:]) / np.abs(expected).max(axis=0)))


def vectors(fmu: Path) -> Vectors:
    """Read the experiment out of an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        manifest = ET.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
        content = {e.get("role"): archive.read(f"{FOLDER}/{e.get('source')}") for e in manifest}
    experiment = ET.fromstring(content["experiment/smoke-test"])[0]
    parameters = ET.fromstring(content["parameter"]).iter(f"{SSV}Parameter")
    return Vectors(
        fmu,
        {p.get("name"): value_of(p[0]) for p in parameters},
        table(content["stimuli"]),
        table(content["result"]),
        float(experiment.get("stepSize")),
    )


def value_of(element: ET.Element) -> float | int | bool:
    return CAST[element.tag.removeprefix(SSV)](element.get("value"))


def table(content: bytes) -> np.ndarray:
    """Read a CSV; names with brackets stay as they are."""
    lines = content.decode().splitlines()
    names = [name.strip('"') for name in lines[0].split(",")]
    return np.array(
        [tuple(map(float, line.split(","))) for line in lines[1:]], dtype=[(n, float) for n in names]
    )


def in_fmpy(given: Vectors, fmu: Path, start_values: dict) -> np.ndarray:
    result = simulate_fmu(
        str(fmu),
        stop_time=0.25,
        step_size=given.step,
        output_interval=given.step,
        start_values=start_values,
        input=given.inputs,
        output=given.output_names,
    )
    return np.column_stack([result[name] for name in given.output_names])
