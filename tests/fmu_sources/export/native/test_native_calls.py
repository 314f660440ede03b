"""Calls out of order, bad values, bad steps: an error with a message, and nothing is changed."""

from __future__ import annotations

import math
import random

import pytest

from fmu_sources.framework.instance import Instance, ModelError
from tests.fmu_sources.export.native.native_library import GUID, Fmu, Fmu3
from tests.fmu_sources.export.native.native_model import MODEL

OK, ERROR = 0, 3
UNSUPPORTED = (
    *("CancelStep", "GetStatus", "GetIntegerStatus", "GetStringStatus", "EnterEventMode", "EnterStepMode"),
    *("EnterConfigurationMode", "ExitConfigurationMode", "EvaluateDiscreteStates", "UpdateDiscreteStates"),
    *("EnterContinuousTimeMode", "GetAdjointDerivative", "GetVariableDependencies", "GetContinuousStates"),
    *("GetNumberOfVariableDependencies", "GetIntervalDecimal", "GetShiftFraction", "SetIntervalFraction"),
    *("GetNumberOfEventIndicators", "GetOutputDerivatives", "CompletedIntegratorStep", "GetEventIndicators"),
)
NO_RESULT_WITHOUT_INSTANCE = (
    *UNSUPPORTED,
    *("SetDebugLogging", "EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset"),
    *("GetReal", "SetReal", "GetInteger", "SetInteger", "GetBoolean", "SetBoolean", "GetString", "SetString"),
    *("GetFloat64", "SetFloat64", "GetInt32", "SetInt32", "GetInt64", "SetInt64", "GetFloat32", "SetBinary"),
    *("GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializeFMUstate", "DeSerializeFMUstate", "DoStep"),
    *("GetFMUState", "SetFMUState", "FreeFMUState", "SerializeFMUState", "DeserializeFMUState"),
    *("SerializedFMUstateSize", "SerializedFMUStateSize", "GetDirectionalDerivative", "GetRealStatus"),
)


def python_message(**values: float) -> str:
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    return "; ".join(instance.problems())


def test_a_wrong_guid_is_refused_with_a_message(fmu: Fmu) -> None:
    other = type(fmu)(fmu.path, MODEL, guid="{another}")

    assert not other.component
    assert other.messages == [f"GUID or instantiation token: not that of this binary, expected {GUID}"]


def test_an_instance_needs_a_name(fmu: Fmu) -> None:
    other = type(fmu)(fmu.path, MODEL, name="")

    assert not other.component
    assert other.messages == ["instance name: got none, expected a text"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("m", -1.5),
        ("m", 0.0),
        ("m", math.nan),
        ("c", 1e4),
        ("k[2]", -1e-9),
        ("u[1]", math.inf),
        ("u[2]", math.nan),
    ],
)
def test_a_bad_value_ends_initialisation_with_the_message_of_the_model(
    fmu: Fmu, name: str, value: float
) -> None:
    assert fmu.enter() == fmu.set(**{name: value}) == OK

    assert fmu.exit() == ERROR
    assert fmu.messages == [python_message(**{name: value})]


@pytest.mark.parametrize(("name", "value"), [("law", 3), ("n", 0), ("n", 10)])
def test_a_bad_whole_number_or_item_is_refused(fmu: Fmu, name: str, value: int) -> None:
    assert fmu.enter() == fmu.set(**{name: value}) == OK

    assert fmu.exit() == ERROR
    assert fmu.messages == [python_message(**{name: value})]


def test_all_bad_values_are_named_in_one_message(fmu: Fmu) -> None:
    bad = {"m": -2.0, "law": 7, "u[1]": -math.inf}
    assert fmu.enter() == fmu.set(**bad) == OK

    assert fmu.exit() == ERROR
    assert fmu.messages == [python_message(**bad)]


def test_numbers_in_messages_are_written_as_python_writes_them(fmu: Fmu) -> None:
    rng = random.Random(5)
    values = [-math.ldexp(rng.random(), rng.randint(-1074, 1000)) for _ in range(300)]
    values += [-(10.0**n) for n in range(-20, 20)] + [
        -123456789.0,
        -5e-324,
        -0.1,
        -1e15,
        -123456789012345678.0,
    ]
    assert fmu.enter() == OK
    for value in values:
        fmu.messages.clear()
        assert fmu.set(m=value) == OK
        assert fmu.exit() == ERROR
        assert fmu.messages == [python_message(m=value)]


def test_a_corrected_value_lets_initialisation_go_on(fmu: Fmu) -> None:
    assert fmu.enter() == fmu.set(m=-1.0) == OK
    assert fmu.exit() == ERROR

    assert fmu.set(m=1.0) == fmu.exit() == fmu.step(0.0, 1e-3) == OK


def test_an_infinite_input_refuses_the_step_and_changes_nothing(fmu: Fmu) -> None:
    fmu.initialise()
    before = fmu.get("y")
    fmu.set(**{"u[2]": math.inf})

    assert fmu.step(0.0, 1e-3) == ERROR
    assert fmu.messages == [python_message(**{"u[2]": math.inf})]
    assert fmu.get("y") == before
    assert fmu.set(**{"u[2]": 0.0}) == fmu.step(0.0, 1e-3) == OK


def test_a_tuned_parameter_is_checked_before_the_next_step(fmu: Fmu) -> None:
    fmu.initialise()
    fmu.set(m=0.0)

    assert fmu.step(0.0, 1e-3) == ERROR
    assert fmu.messages == ["m: value not allowed, got 0.0 kg, expected above 0.0"]


def test_a_fault_within_a_long_step_ends_it_there_though_it_would_be_gone_at_its_end(fmu: Fmu) -> None:
    """An undamped swing of 8.7 m: sqrt(800 N/m / 6 kg) = 11.5 rad/s, back at the middle after 0.544 s."""
    values = {"law": 1, "c": 0.0, "v": 100.0, "y": 0.0}
    python, short = Instance(MODEL), Instance(MODEL)
    for instance in (python, short):
        for name, value in values.items():
            instance[name] = value
        instance.initialise()
    assert fmu.enter() == fmu.set(**values) == fmu.exit() == OK

    with pytest.raises(ModelError, match="y: off the table") as refused:
        python.step(0.0, 0.544)
    with pytest.raises(ModelError, match="y: off the table") as stepwise:
        run_until_refused(short)
    assert fmu.step(0.0, 0.544) == ERROR
    assert fmu.messages == [str(refused.value)]
    assert python.time == pytest.approx(short.time) == pytest.approx(math.asin(5 / 8.66) / 11.55, abs=1e-3)
    assert str(refused.value)[:30] == str(stepwise.value)[:30]


def run_until_refused(instance: Instance) -> None:
    for k in range(544):
        instance.step(k * 1e-3, 1e-3)


def test_a_step_that_is_no_multiple_of_the_sampling_is_refused(fmu: Fmu) -> None:
    fmu.initialise()

    assert fmu.step(0.0, 1.5e-3) == ERROR
    assert fmu.messages == [
        "communication step: not a multiple of T, got 0.0015 s, expected a multiple of 0.001 s"
    ]
    assert fmu.step(0.0, 3e-3) == OK


@pytest.mark.parametrize("h", [0.0, -1e-3, math.nan, math.inf, 1e300])
def test_a_step_that_is_no_positive_number_is_refused(fmu: Fmu, h: float) -> None:
    fmu.initialise()

    assert fmu.step(0.0, h) == ERROR
    assert fmu.messages[0].startswith(("communication step: not a", "communication step: too long for T"))


def test_a_step_must_start_where_the_last_one_ended(fmu: Fmu) -> None:
    fmu.initialise(2.0)

    assert fmu.step(1.0, 1e-3) == ERROR
    assert fmu.messages == [
        "communication point: not where the last step ended, got 1.0 s, expected about 2.0 s"
    ]
    assert fmu.step(2.0, 1e-3) == OK


def test_a_fault_of_the_model_fails_the_instance_until_it_is_reset(fmu: Fmu) -> None:
    fmu.initialise()
    fmu.set(**{"u[1]": 1e9})

    assert fmu.step(0.0, 0.1) == ERROR
    assert fmu.messages[0].startswith("y: off the table, got ")
    assert fmu.messages[0].endswith(" m, expected at most 5.0 m")
    assert fmu.step(0.1, 0.1) == ERROR
    assert fmu.reset() == fmu.initialise() == fmu.step(0.0, 0.1) == OK


def test_a_result_that_is_not_finite_is_never_silent(fmu: Fmu) -> None:
    fmu.initialise()
    fmu.set(**{"u[1]": 1e308, "u[2]": 0.0, "m": 1e-300})

    assert fmu.step(0.0, 1e-3) == ERROR
    assert "got " in fmu.messages[0]


def test_outputs_follow_the_start_values_during_initialisation(fmu: Fmu) -> None:
    fmu.enter()
    first = fmu.get("f")
    fmu.set(y=-0.2)

    assert first == pytest.approx(math.tanh(80.0))
    assert fmu.get("f") == pytest.approx(math.tanh(-160.0))
    assert fmu.get("stretched") == 0


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("f", 1.0, "which is an output"),
        ("T", 1e-3, "expected it before the first step"),
        ("y", 1.0, "expected it before the first step"),
        ("law", 1, "expected it before the first step"),
    ],
)
def test_what_may_not_be_set_during_a_run_is_refused(fmu: Fmu, name: str, value: float, reason: str) -> None:
    fmu.initialise()

    assert fmu.set(**{name: value}) == ERROR
    assert reason in fmu.messages[0]


def test_calls_out_of_order_are_refused_and_do_no_harm(fmu: Fmu) -> None:
    assert fmu.step(0.0, 1e-3) == ERROR
    assert fmu.exit() == ERROR
    assert fmu.terminate() == ERROR
    assert fmu.status_of_get("y") == ERROR
    assert fmu.initialise() == OK
    assert fmu.enter() == ERROR
    assert fmu.step(0.0, 1e-3) == fmu.terminate() == OK
    assert fmu.step(1e-3, 1e-3) == fmu.set(m=1.0) == ERROR
    assert fmu.get("y") != 0.0
    name = f"fmi{fmu.version}DoStep"
    expected = f"{name}: call not allowed now, got it while instantiated, expected it while stepping"
    assert fmu.messages[0] == expected


def test_unknown_and_hidden_references_and_other_types_are_refused(fmu: Fmu) -> None:
    fmu.initialise()
    hidden = fmu.index["count"]

    assert fmu.status_of_get("count") == ERROR
    assert f"value reference unknown, got {hidden}" in fmu.messages[0]
    assert fmu.transfer("Get", "boolean", [fmu.index["y"]], (fmu.types["boolean"] * 1)()) == ERROR
    assert "got y, which is of type real, expected type Boolean" in fmu.messages[1]


def test_reset_returns_to_the_start_values(fmu: Fmu) -> None:
    fmu.set(m=5.0, law=1)
    fmu.initialise()
    fmu.step(0.0, 1e-3)

    assert fmu.reset() == fmu.enter() == OK
    assert (fmu.get("m"), fmu.get("law"), fmu.get("y")) == (2.0, 2, 0.1)


def test_time_is_the_variable_behind_the_last_one_in_fmi_3(fmu: Fmu) -> None:
    if not isinstance(fmu, Fmu3):
        pytest.skip("FMI 2.0 has no time variable")
    fmu.initialise(1.5)
    fmu.step(1.5, 2e-3)
    values = (fmu.types["real"] * 1)()

    assert fmu.transfer("Get", "real", [len(MODEL.all_variables)], values) == OK
    assert values[0] == 1.502


def test_every_function_survives_a_call_without_an_instance(fmu: Fmu) -> None:
    zero = [None] * 12
    for function in NO_RESULT_WITHOUT_INSTANCE:
        call = getattr(fmu.library, f"fmi{fmu.version}{function}", None)
        assert call is None or call(*zero) == ERROR


def test_what_the_fmu_has_not_is_an_error_with_a_message(fmu: Fmu) -> None:
    present = [f for f in UNSUPPORTED if hasattr(fmu.library, f"fmi{fmu.version}{f}")]
    for function in present:
        assert fmu.call(f"fmi{fmu.version}{function}", *([None] * 9)) == ERROR

    assert len(fmu.messages) == len(present) > 0
    assert all("not supported" in message for message in fmu.messages)
