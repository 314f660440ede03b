"""Numbers that a double, or a float, does not hold: exact, refused, or never there."""

import pytest

from master.errors import ConfigError
from master.experiment.prepare import prepare
from master.fmi.description_reader import read_description
from master.fmi.fmi3 import Fmi3Slave
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED

BEYOND = 2**53 + 1  # the first integer that no double holds


@pytest.fixture
def slave(fmu):
    made = Fmi3Slave("a", read_description(fmu("3.0")))
    yield made
    made.close(failed=False)


@pytest.mark.parametrize(
    ("name", "value"),
    [("Int64", BEYOND), ("Int64", -(2**63)), ("Int64", 2**63 - 1), ("UInt64", 2**64 - 1), ("UInt64", BEYOND)],
)
def test_an_integer_of_64_bits_reaches_the_fmu_with_all_digits(slave, fmu, tmp_path, name, value):
    file = tmp_path / "system.yaml"
    start = f"{{{name}_in: {value}}}"
    fmus = f"fmus: {{a: {{source: ./types3.fmu, start: {start}}}}}"
    file.write_text(f"name: n\nstep_size: 1\nstop_time: 1\n{fmus}\n")
    slave.enter_initialisation(prepare(file).system.instances["a"].start, 0.0)
    slave.exit_initialisation()

    assert slave.get([slave.description.by_name[f"{name}_out"]]) == [value]


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("Int64", 2**63, "expected at most 9223372036854775807"),
        ("UInt64", -1, "expected at least 0"),
        ("UInt64", 2**64, "expected at most 18446744073709551615"),
        ("Int64", float(2**53 + 2), "expected an integer with all of its digits"),
        ("Int32", 2.5, "expected an integer"),
        ("Int32", True, "expected a number"),
        ("Float64", True, "expected a number"),
        ("Float64", 10**400, "expected at most 1.79769313e[+]308"),
        ("Float64", "1_000", "expected a number"),
        ("Float32", 1e39, "expected at most 3.40282347e[+]38"),
        ("Float32", -1e39, "expected at least -3.40282347e[+]38"),
        ("Boolean", 2, "expected true or false"),
    ],
)
def test_a_value_that_the_type_does_not_hold_is_refused(fmu, tmp_path, name, value, problem):
    fmu("3.0")
    with pytest.raises(ConfigError, match=f"start.{name}_in: value not allowed, got .*{problem}"):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": {f"{name}_in": value}}})


def test_a_wire_carries_integers_up_to_the_last_exact_one(fmu, tmp_path):
    fmu("3.0")
    fmus = {
        "a": {"source": "./types3.fmu", "start": {"Int64_in": 2**53 - 1}},
        "b": {"source": "./types3.fmu"},
    }
    result = run(tmp_path, fmus, wires(("a.Int64_out", "b.Int64_in"))).result

    assert result["b.Int64_out"][-1] == 2**53 - 1


@pytest.mark.parametrize("name", ["Int64", "UInt64"])
def test_an_integer_that_a_wire_would_round_ends_the_run(fmu, tmp_path, name):
    fmu("3.0")
    start = {f"{name}_in": BEYOND}
    fmus = {"a": {"source": "./types3.fmu", "start": start}, "b": {"source": "./types3.fmu"}}
    outcome = run(tmp_path, fmus, wires((f"a.{name}_out", f"b.{name}_in")))

    assert (outcome.status, outcome.steps) == ("failed", 0)
    assert f"b.{name}_in: value does not fit {name}, got 9.0072e+15, expected from" in str(outcome.error)


def test_an_integer_that_the_rows_round_is_told(fmu, tmp_path):
    fmu("3.0")
    start = {"Int64_in": BEYOND, "UInt64_in": 2**53 - 1}
    fmus = {"a": {"source": "./types3.fmu", "start": start}, "b": {"source": "./types3.fmu"}}
    outcome = run(tmp_path, fmus, wires(("a.Int64_out", "b.Float64_in")))

    end = "the rows have it rounded to a double"
    assert (outcome.status, outcome.steps) == ("completed", 5)
    assert outcome.warnings == [f"a.Int64_out reaches 2^53 from t=0.1 s on; {end}"]


def test_a_number_that_a_float_does_not_hold_ends_the_run(fmu, tmp_path):
    fmu("3.0")
    fmus = {"a": {"source": "./types3.fmu", "start": {"Float64_in": 1e39}}, "b": {"source": "./types3.fmu"}}
    outcome = run(tmp_path, fmus, wires(("a.Float64_out", "b.Float32_in")))

    assert (outcome.status, outcome.steps) == ("failed", 0)
    problem = "b.Float32_in: value does not fit Float32, got 1e+39, expected from -3.40282e+38 to 3.40282e+38"
    assert str(outcome.error) == f"b at t=0 s: {problem}"
