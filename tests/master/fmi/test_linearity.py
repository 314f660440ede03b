from __future__ import annotations

from xml.etree import ElementTree as ET

from fmu_sources.composed.registry import load, model_files
from fmu_sources.export.fmi2_xml import describe_fmi2
from fmu_sources.export.fmi3_xml import describe_fmi3
from fmu_sources.export.native_flavour import NATIVE
from fmu_sources.framework.model import Model
from master.fmi.linearity import DeclaredLearning, declared_learning, declared_linear


def both(name):
    model = load(name)
    return [ET.fromstring(describe(model, NATIVE, "{}")) for describe in (describe_fmi2, describe_fmi3)]


def test_the_compensator_says_with_which_identifier_it_is_linear_and_what_holds_the_others():
    for root in both("compensator"):
        (linear,) = declared_linear(root)
        assert (linear.parameter, linear.value) == ("identifier", "fixed")
        assert declared_learning(root) == (
            DeclaredLearning("identifier", "kalman", "identification_held"),
            DeclaredLearning("identifier", "rls", "identification_held"),
        )


def test_the_contact_says_that_its_stiffness_may_vary():
    for name in ("docking_contact", "real_docking", "docking_contact__rope_force_slack"):
        for root in both(name):
            (linear,) = declared_linear(root)
            assert (linear.parameter, float(linear.value)) == ("k_p_amplitude", 0.0)
            assert linear.frequency == "k_p_frequency"


def test_elements_of_other_tools_with_the_same_names_are_not_read():
    root = ET.fromstring("<a><Tool name='other'><Linear/><Learning/></Tool></a>")

    assert declared_linear(root) == ()
    assert declared_learning(root) == ()


def test_what_is_declared_exists_in_the_model():
    for name in model_files():
        model: Model = load(name)
        variables = {v.name: v for v in model.variables}
        for linear in model.linear:
            items = variables[linear.parameter].items
            assert items is None or linear.value in items.__members__
            assert linear.frequency is None or variables[linear.frequency].unit == "Hz"
        for learning in model.learning:
            assert variables[learning.held_by].boolean
            assert not variables[learning.held_by].fixed
            assert learning.item in variables[learning.by].items.__members__
