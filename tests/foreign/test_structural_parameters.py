"""Structural parameters of FMI 3.0: set in configuration mode, and arrays have the sizes that they say."""

import pytest

from master.api import prepare_to_run
from master.errors import ConfigError
from master.experiment.prepare import Request
from master.stepping.simulate import simulate
from tests.foreign.build import FOLDERS, HERE, compile_c, write_fmu
from tests.foreign.foreign import COMPILED

pytestmark = COMPILED

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="structural" instantiationToken="structural">
  <CoSimulation modelIdentifier="structural"/>
  <ModelVariables>
    <UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="2"
      min="1" max="9"/>
    <Float64 name="u" valueReference="2" causality="input" start="0.5 0.5">
      <Dimension valueReference="1"/>
    </Float64>
    <Float64 name="y" valueReference="3" causality="output"><Dimension valueReference="1"/></Float64>
  </ModelVariables>
  <ModelStructure><Output valueReference="3"/></ModelStructure>
</fmiModelDescription>
"""
SYSTEM = """\
name: structural
step_size: 0.1
stop_time: 0.2
fmus:
  a: {source: structural.fmu, A}
  b: {source: structural.fmu, B}
coupling: {order: [a, b]}
connections: [{from: a.y, to: b.u}]
variants: VARIANTS
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_c("3.0", tmp_path_factory.mktemp("structural"), HERE / "structural3.c")


@pytest.fixture
def prepared(library, tmp_path):
    def prepare(a="", b="", *assignments, variant=None, variants="{}"):
        write_fmu(tmp_path / "structural.fmu", DESCRIPTION, {f"{FOLDERS['3.0']}/structural.so": library})
        text = SYSTEM.replace(", A}", f"{a}}}").replace(", B}", f"{b}}}").replace("VARIANTS", variants)
        (tmp_path / "system.yaml").write_text(text)
        return prepare_to_run(tmp_path / "system.yaml", Request(variant, assignments))

    return prepare


def last_row(experiment):
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid)
    assert outcome.error is None, outcome.error
    return {signal: outcome.result[signal][-1] for signal in outcome.result.names}


PARAMETERS = ", parameters: {n: 4}"
THREE = ", parameters: {n: 3}"


def test_a_structural_parameter_resizes_the_arrays_that_refer_to_it(prepared):
    row = last_row(prepared(", parameters: {n: 4}, start: {u: [1, 2, 3, 4]}", PARAMETERS))

    assert [row[f"a.y[{i}]"] for i in (1, 2, 3, 4)] == [1.0, 4.0, 9.0, 16.0]
    assert [row[f"b.y[{i}]"] for i in (1, 2, 3, 4)] == [1.0, 8.0, 27.0, 64.0]


def test_start_values_for_another_size_stay_those_of_the_fmu(prepared):
    row = last_row(prepared(", parameters: {n: 3}, start: {'u[3]': 7}", THREE))

    assert [row[f"a.y[{i}]"] for i in (1, 2, 3)] == [0.5, 1.0, 21.0]


def test_set_and_variants_resize_arrays(prepared):
    grown = prepared("", "", "a.n=3", "b.n=3", "a.u=[1, 2, 3]")
    variants = "{large: {a: {n: 3, u: [1, 2, 3]}, b: {n: 3}}}"
    chosen = prepared("", "", variant="large", variants=variants)

    assert last_row(grown)["b.y[3]"] == last_row(chosen)["b.y[3]"] == 27.0
    assert "b.y[3]" not in last_row(prepared("", "", variants=variants))


FAULTS = [
    (", parameters: {n: 0}", r"parameters\.n: value not allowed, got 0, expected at least 1"),
    (", parameters: {n: 10}", r"parameters\.n: value not allowed, got 10, expected at most 9"),
    (", parameters: {n: 2.5}", r"parameters\.n: value not allowed, got 2\.5, expected an integer"),
    (", parameters: {n: 3}", r"shapes differ, got a\.y up to \[3\] -> b\.u up to \[2\]"),
    (", parameters: {n: 2}, start: {u: [1, 2, 3]}", r"got a list of 3, expected 2 values or one for all"),
]


@pytest.mark.parametrize(("a", "fault"), FAULTS)
def test_sizes_that_do_not_fit_are_refused(prepared, a, fault):
    with pytest.raises(ConfigError, match=fault):
        prepared(a)
