import pytest

from master.fmi.description import Kind, Variable
from master.fmi.value_types import BOOLEAN, FLOAT64, INT32
from master.fmi.values import parse
from master.text.scalar import Plain
from tests.stubs import METRE, bench, clock, gain, integrator, wire

HEAD = (
    "name: test\nstop_time: 1.0\nfmus:\n  clock: {source: clock.fmu}\n  mass:\n    source: integrator.fmu\n"
)

CHOICE = Variable("choice", 0, Kind.INTEGER, INT32, "parameter", "fixed", items={"kalman": 1, "rls": 2})
SWITCH = Variable("on", 1, Kind.BOOLEAN, BOOLEAN, "parameter", "fixed")
REAL = Variable("size", 2, Kind.REAL, FLOAT64, "parameter", "fixed", minimum=0.0, maximum=10.0)
WHOLE = Variable("n", 3, Kind.INTEGER, INT32, "parameter", "fixed")
TEXT = Variable("label", 4, Kind.STRING, INT32, "parameter", "fixed")


@pytest.mark.parametrize(
    ("variable", "value", "parsed"),
    [
        (CHOICE, "rls", 2),
        (CHOICE, "2", 2.0),
        (CHOICE, 1, 1.0),
        (SWITCH, True, 1.0),
        (SWITCH, "false", 0.0),
        (REAL, "2.5", 2.5),
        (WHOLE, 3.0, 3.0),
        (TEXT, 3, "3"),
    ],
)
def test_a_value_becomes_what_the_fmu_takes(variable, value, parsed):
    assert parse(variable, value) == parsed


@pytest.mark.parametrize(
    ("variable", "value", "fault"),
    [
        (CHOICE, "kalmann", "expected 'kalman' (of kalman, rls)"),
        (CHOICE, 3, "expected one of kalman, rls"),
        (CHOICE, "3", "expected one of kalman, rls"),
        (SWITCH, 2, "expected true or false"),
        (REAL, "wide", "expected a number"),
        (REAL, float("nan"), "expected a finite number"),
        (REAL, "inf", "expected a number"),
        (REAL, Plain(".inf"), "expected a finite number"),
        (REAL, True, "expected a number"),
        (REAL, -1, "expected at least 0"),
        (REAL, 11, "expected at most 10"),
        (WHOLE, 1.5, "expected an integer"),
    ],
)
def test_a_value_that_does_not_fit_says_what_is_expected(variable, value, fault):
    with pytest.raises(ValueError, match="expected") as caught:
        parse(variable, value)

    assert str(caught.value) == fault


@pytest.mark.parametrize("variable", [CHOICE, WHOLE])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), ".nan", "-inf"])
def test_an_integer_that_is_not_finite_is_refused(variable, value):
    with pytest.raises(ValueError, match="expected"):
        parse(variable, value)


def test_a_configured_value_stands_before_the_own_one_of_the_fmu():
    system = bench({"a": integrator(METRE), "b": integrator()}, start={"a": {"x": 3.0}}).system

    assert system.instances["a"].value_of("x") == 3.0
    assert system.instances["b"].value_of("x") == 0.0
    assert system.instances["b"].value_of("z") is None


def test_a_port_is_found_by_its_qualified_name():
    system = bench({"a": clock(), "b": gain()}, [wire("a.t", "b.u")]).system

    assert system.port("b.u").variable.causality == "input"
    assert [w.source.name for w in system.wires_into("b")] == ["a.t"]


@pytest.mark.parametrize(
    ("entry", "fault"),
    [
        (
            "start: {x: .nan}",
            "fmus.mass.start.x: value not allowed, got .nan m, expected a finite number",
        ),
        (
            "parameters: {size: -1}",
            "fmus.mass.parameters.size: value not allowed, got -1 m, expected at least 0",
        ),
        (
            "parameters: {choice: frist}",
            "fmus.mass.parameters.choice: value not allowed, got 'frist', "
            "expected 'first' (of first, second)",
        ),
        (
            "parameters: {sise: 1}",
            "fmus.mass.parameters.sise: no such variable in mass (integrator), got 'sise', "
            "expected 'size' (of u, x, size, choice, on, count, label)",
        ),
    ],
)
def test_a_start_value_that_does_not_fit_is_refused(bay, entry, fault):
    assert bay.faults(HEAD + f"    {entry}\n") == [f"system.yaml:7: {fault}"]


def test_a_value_that_the_fmu_calculates_cannot_be_set(bay):
    text = HEAD + "  late: {source: gain.fmu, start: {y: 1}}\n"

    assert bay.faults(text) == [
        "system.yaml:7: fmus.late.start.y: cannot be set, got 'y' (calculated by the FMU), expected one of u"
    ]


def test_an_input_with_a_start_value_and_a_connection_has_two_sources(bay):
    text = HEAD + "    start: {u: 1}\nconnections:\n  - {from: clock.t, to: mass.u}\n"

    assert bay.faults(text) == [
        "system.yaml:7: fmus.mass.start.u: has two sources, "
        "got a start value and a connection to mass.u, expected one"
    ]


def test_an_input_with_two_connections_has_two_sources(bay):
    text = HEAD + "connections:\n  - {from: clock.t, to: mass.u}\n  - {from: mass.x, to: mass.u}\n"

    assert bay.faults(text) == [
        "system.yaml:9: connections[1].to: has two sources, got 'mass.u' again, "
        "expected one connection (the other is connections[0])"
    ]


@pytest.mark.parametrize(
    ("connection", "fault"),
    [
        (
            "{from: clok.t, to: mass.u}",
            "connections[0].from: no such FMU, got 'clok', expected 'clock' (of clock, mass)",
        ),
        (
            "{from: clock.tt, to: mass.u}",
            "connections[0].from: no such output of clock (clock), got 'tt', expected 't' (of t)",
        ),
        (
            "{from: mass.u, to: mass.u}",
            "connections[0].from: no such output of mass (integrator), got 'u', expected one of x",
        ),
        (
            "{from: clock.t, to: mass.x}",
            "connections[0].to: no such input of mass (integrator), got 'x', expected one of u",
        ),
    ],
)
def test_a_connection_joins_an_output_and_an_input_that_exist(bay, connection, fault):
    assert bay.faults(HEAD + f"connections:\n  - {connection}\n") == [f"system.yaml:8: {fault}"]


def test_a_unit_mismatch_is_refused_with_both_units(bay):
    text = HEAD + "  force: {source: newton.fmu}\nconnections:\n  - {from: mass.x, to: force.u}\n"

    assert bay.faults(text) == [
        "system.yaml:9: connections[0]: units differ, got mass.x [m] -> force.u [N], "
        "expected the same quantity"
    ]


def test_compared_and_limited_signals_are_outputs_that_exist(bay):
    text = HEAD + "compare: {signal: mass.y, offset: 1.0}\nlimits:\n  clock.u: 1.0\n"

    assert bay.faults(text) == [
        "system.yaml:7: compare.signal: no such output of mass (integrator), got 'y', expected one of x",
        "system.yaml:9: limits.clock.u: no such output of clock (clock), got 'u', expected one of t",
    ]


def test_faults_of_all_fmus_and_connections_come_at_once(bay):
    text = HEAD + "    start: {x: .nan}\n    parameters: {size: 20, on: 3}\nconnections:\n"
    text += "  - {from: clock.x, to: mass.u}\n  - {from: mass.x, to: massif.u}\n"

    places = [fault.split(": ")[:2] for fault in bay.faults(text)]

    assert sorted(places) == [
        ["system.yaml:10", "connections[0].from"],
        ["system.yaml:11", "connections[1].to"],
        ["system.yaml:7", "fmus.mass.start.x"],
        ["system.yaml:8", "fmus.mass.parameters.on"],
        ["system.yaml:8", "fmus.mass.parameters.size"],
    ]
