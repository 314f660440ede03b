"""
Test vectors inside the FMU, in the layout of FMI-LS-REF: parameters, inputs and expected outputs.

    fmu_sources/<folder>/reference/<model>.ssv       parameters and start values, SSP 1.0
    fmu_sources/<folder>/reference/<model>_in.csv    inputs; a row holds from its time to the next one
    fmu_sources/<folder>/reference/<model>_out.csv   outputs, from an independent computation

The files are made by `tests/oracles`, from other code than the model's, and committed.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

from ..framework.model import Model
from .facts import document

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
ROUNDING, INTEGRATION = 1e-12, 1e-8


def agreement(model: Model) -> float:
    """Return how close the FMU comes to the exact outputs, relative to the largest value of each."""
    if model.accuracy is not None:
        return model.accuracy
    return INTEGRATION if model.n_continuous else ROUNDING


def reference_paths(model: Model, model_file: Path) -> list[Path]:
    """List the committed files of a model's reference experiment; none if it has none."""
    folder = model_file.parent / "reference"
    names = (f"{model.name}.ssv", f"{model.name}_in.csv", f"{model.name}_out.csv")
    return [folder / name for name in names if (folder / name).is_file()]


def reference_files(model: Model, model_file: Path) -> dict[str, bytes]:
    """Path in the FMU to content: the experiment with its manifest, or nothing."""
    paths = reference_paths(model, model_file)
    if not paths:
        return {}
    contents = {f"{FOLDER}/{path.name}": path.read_bytes() for path in paths}
    stop, step = _grid(contents[f"{FOLDER}/{model.name}_in.csv"])
    return {
        **contents,
        f"{FOLDER}/fmi-ls-manifest.xml": _manifest(model.name),
        f"{FOLDER}/experiments.xml": _experiments(model.name, stop, step),
    }


def _grid(table: bytes) -> tuple[str, str]:
    """Read the last time and the step from the first column."""
    times = [line.partition(",")[0] for line in table.decode().splitlines()[1:]]
    return times[-1], times[1]


def _manifest(name: str) -> bytes:
    ET.register_namespace("fmi-ls", MANIFEST_NAMESPACE)
    about = {
        "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
        "fmi-ls-version": "1.0.0-alpha.1",
        "fmi-ls-description": "Reference experiment with its expected result",
    }
    root = ET.Element(
        "fmiReferences", {f"{{{MANIFEST_NAMESPACE}}}{key}": text for key, text in about.items()}
    )
    parameters = "application/x-ssp-parameter-set"
    related = (
        (
            "experiments.xml",
            "application/xml",
            "experiment/smoke-test",
            "Experiment: which files, time and step",
        ),
        (f"{name}.ssv", parameters, "parameter", "Parameters and start values; all others keep theirs"),
        (f"{name}_in.csv", "text/csv", "stimuli", "Inputs; a row is set at its time and holds for one step"),
        (
            f"{name}_out.csv",
            "text/csv",
            "result",
            "Expected outputs after the step that ends at the row's time",
        ),
    )
    for source, kind, role, description in related:
        ET.SubElement(root, "Related", source=source, type=kind, role=role, description=description)
    return document(root)


def _experiments(name: str, stop: str, step: str) -> bytes:
    root = ET.Element("Experiments", name=f"Reference of {name}")
    experiment = ET.SubElement(
        root, "Experiment", name="reference", startTime="0", stopTime=stop, stepSize=step
    )
    ET.SubElement(experiment, "Parameters", source=f"{name}.ssv")
    ET.SubElement(experiment, "Stimuli", source=f"{name}_in.csv", type="text/csv")
    ET.SubElement(experiment, "References", source=f"{name}_out.csv", type="text/csv")
    return document(root)
