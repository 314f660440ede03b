"""Analysis and evaluation work for any FMU: they name no variable and no model of the docking loop."""

from __future__ import annotations

import ast
from pathlib import Path

from fmu_sources.compensator.compensator import Compensator
from fmu_sources.docking_contact.docking_contact import DockingContact
from fmu_sources.force_sensor.force_sensor import ForceSensor
from fmu_sources.motion_simulator.motion_simulator import MotionSimulator
from fmu_sources.motion_simulator.motion_simulator_linear import MotionSimulatorLinear
from fmu_sources.real_docking.real_docking import RealDocking
from fmu_sources.spacecraft.spacecraft import Spacecraft

MASTER = Path(__file__).parents[3] / "master"
MODELS = (
    Compensator,
    DockingContact,
    ForceSensor,
    MotionSimulator,
    MotionSimulatorLinear,
    RealDocking,
    Spacecraft,
)
GENERAL = {"time"}


def docking_names() -> set[str]:
    variables = {v.name for model in MODELS for v in model.variables if len(v.name) > 2}
    return (variables | {model.name for model in MODELS}) - GENERAL


def literals(package: str) -> dict[str, str]:
    """String constants by file, docstrings left out."""
    found = {}
    for file in (MASTER / package).rglob("*.py"):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        documentation = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node)
        }
        for node in ast.walk(tree):
            if (
                isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and id(node) not in documentation
            ):
                found |= dict.fromkeys(node.value.split("."), file.name)
    return found


def test_the_analysis_names_nothing_of_the_docking_models():
    found = literals("analysis")

    assert len(docking_names()) > 60
    assert {name: found[name] for name in docking_names() & set(found)} == {}


def test_the_evaluation_names_only_the_keys_of_its_metrics():
    found = literals("evaluation")

    assert {name: found[name] for name in docking_names() & set(found)} == {}
