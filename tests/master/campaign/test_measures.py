"""Measures of a run, of signals whose numbers are known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from master.campaign.campaign import Measure
from master.campaign.measures import load_function, measured, metrics
from master.errors import ConfigError
from master.recording.recorder import Result

TIME = np.linspace(0.0, 10.0, 1001)
SINE = np.sin(2.0 * np.pi * 0.5 * TIME)  # of 0.5 Hz: five cycles
RAMP = TIME - 4.0
DECAY = 2.0 * np.exp(-TIME)
RUN = Result(
    TIME,
    ("a.sine", "a.ramp", "a.decay", "a.lost"),
    ("m", "m", "m", "m"),
    np.column_stack([SINE, RAMP, DECAY, np.full_like(TIME, np.nan)]),
)


def number(**keys):
    return measured(Measure.model_validate(keys), RUN, None)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"minimum": "a.ramp"}, -4.0),
        ({"maximum": "a.ramp"}, 6.0),
        ({"largest": "a.ramp"}, 6.0),
        ({"largest": "a.ramp", "to": 1.0}, 4.0),
        ({"mean": "a.ramp"}, 1.0),
        ({"mean": "a.ramp", "from": 4.0, "to": 6.0}, 1.0),
        ({"final": "a.ramp", "to": 4.0}, 0.0),
        ({"rms": "a.sine", "from": 0.01}, np.sqrt(0.5)),  # whole cycles
    ],
)
def test_a_number_of_a_signal_between_two_times(keys, expected):
    assert number(**keys) == pytest.approx(expected, abs=1e-9)


def test_a_level_is_crossed_between_two_rows_in_the_direction_that_is_asked_for():
    assert number(first_crossing="a.ramp", level=1.234) == pytest.approx(5.234, abs=1e-12)
    assert number(first_crossing="a.ramp", level=1.234, direction="falling") is None
    assert number(first_crossing="a.decay", level=1.0) == pytest.approx(np.log(2.0), abs=2e-5)
    assert number(first_crossing="a.decay", level=1.0, direction="rising") is None
    assert number(first_crossing="a.ramp", level=7.0) is None


def test_a_signal_has_settled_when_it_is_last_outside_of_its_band():
    last = number(settling_time="a.decay", band=0.2)

    assert last == pytest.approx(np.log(10.0), abs=0.011)  # 2 exp(-t) = 0.2, seen in rows 10 ms apart
    assert number(settling_time="a.decay", band=3.0) == 0.0


def test_energy_is_the_integral_of_a_product():
    energy = number(energy="a.decay", **{"with": "a.decay"})  # 4 exp(-2 t) from 0 to 10 s

    assert energy == pytest.approx(2.0 * (1.0 - np.exp(-20.0)), rel=1e-4)


def test_a_function_of_the_user_has_the_rows_between_the_times():
    seen = {}

    def range_of(time, signals):
        seen.update(first=time[0], last=time[-1], names=set(signals))
        return np.ptp(signals["a.ramp"])

    measure = Measure.model_validate({"function": "own.py:range_of", "from": 1.0, "to": 3.0})

    assert measured(measure, RUN, range_of) == pytest.approx(2.0)
    assert seen == {"first": 1.0, "last": 3.0, "names": set(RUN.names)}


@pytest.mark.parametrize("keys", [{"mean": "a.lost"}, {"maximum": "a.ramp", "from": 11.0}])
def test_what_has_no_finite_value_is_no_number(keys):
    assert number(**keys) is None


def test_metrics_of_a_run_that_compares_nothing_are_unknown():
    assert metrics(RUN, None, ("rms_s_act",), 4) == {"rms_s_act": None}
    assert metrics(RUN, None, (), 4) == {}


def test_a_function_is_loaded_from_a_file_next_to_the_campaign(tmp_path):
    (tmp_path / "own.py").write_text("LEVEL = 3\n\ndef double(time, signals):\n    return 2 * LEVEL\n")

    assert load_function("own.py:double", tmp_path)(TIME, {}) == 6


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("other.py:double", "no such file, got 'other.py:double', expected file.py:name of a Python file"),
        ("own.py:treble", "no such function, got 'own.py:treble', expected one of double"),
        ("broken.py:f", "cannot be loaded: ZeroDivisionError: division by zero, got 'broken.py:f'"),
    ],
)
def test_a_function_that_is_not_there_is_refused(tmp_path, text, message):
    (tmp_path / "own.py").write_text("def double(time, signals):\n    return 2\n")
    (tmp_path / "broken.py").write_text("1 / 0\n")

    with pytest.raises(ConfigError) as refusal:
        load_function(text, tmp_path)

    assert message in str(refusal.value)
