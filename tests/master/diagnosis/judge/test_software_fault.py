"""Faults of software on a part that is a formula: each kind is found by the replay that leaves nothing."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from master.diagnosis.judge.software_fault import software_fault, ticks_between_rows, unknown_rows
from master.fmi.description import Kind

N = 2000
RNG = np.random.default_rng(3)
A = np.cumsum(RNG.standard_normal(N))
B = np.cumsum(RNG.standard_normal(N))
TABLE = np.column_stack([A, B])


def replay(table, values):
    """Y = gain * a + b, or a alone where the switch is off."""
    on = float(values["soft.on"])
    return (values["soft.gain"] * table[:, 0] + on * 0.3 * table[:, 1] ** 2)[:, None]


class Bench:
    def __init__(self, change=None):
        self.change = change or (lambda table: table)
        self.part = SimpleNamespace(
            fmus=("soft",),
            columns=[SimpleNamespace(signal="a"), SimpleNamespace(signal="b")],
            compared={"soft.y": "y"},
        )
        self.outputs = ["soft.y"]
        self.in_use = np.arange(N) >= 20
        self.period = 1e-3

    def signal(self, name):
        return TABLE[:, "ab".index(name)]

    def compared_rows(self, values):
        return values

    def with_inputs(self, change):
        return Bench(change)

    def predict(self, player, given):
        return replay(self.change(TABLE), {f"soft.{k}": v for k, v in given["soft"].items()})


def study(measured):
    nominal = {"soft.gain": 2.0, "soft.on": 1.0}
    variables = [
        SimpleNamespace(name="on", causality="parameter", kind=Kind.BOOLEAN, start="true"),
        SimpleNamespace(name="gain", causality="parameter", kind=Kind.REAL, start="2.0"),
    ]

    def values_with(values):
        return {"soft": {k.partition(".")[2]: v for k, v in (nominal | dict(values)).items()}}

    return SimpleNamespace(
        name="soft",
        bench=Bench(),
        measured=measured,
        pool=SimpleNamespace(player=lambda effects: None),
        system=SimpleNamespace(descriptions={"soft": SimpleNamespace(variables=variables)}),
        say=lambda text: None,
        replayed_with_noise=with_noise,
        values_with=values_with,
        simulate=lambda effects, values, everything: replay(TABLE, nominal | dict(values)),
    )


def with_noise(values, deviations, n_draws):
    noise = np.random.default_rng(5).standard_normal((n_draws, N, 2)) * deviations
    quiet = replay(TABLE, {"soft.gain": 2.0, "soft.on": 1.0})
    return np.stack([replay(TABLE + own, {"soft.gain": 2.0, "soft.on": 1.0}) - quiet for own in noise])


def late(values):
    return np.concatenate([values[:1], values[:-1]])


RIGHT = replay(TABLE, {"soft.gain": 2.0, "soft.on": 1.0})[:, 0]


@pytest.mark.parametrize(
    ("y", "kind", "where"),
    [
        (late(RIGHT), "is one tick late", "the output soft.y"),
        (-RIGHT, "has the other sign", "the output soft.y"),
        (np.clip(RIGHT, -20.0, 60.0), "is clipped", "the output soft.y"),
        (0.25 * np.round(RIGHT / 0.25), "is rounded to 0.25", "the output soft.y"),
        (RIGHT[np.arange(N) // 5 * 5], "is stale: held for 5 ticks", "the output soft.y"),
        (2.0 * late(A) + 0.3 * B**2, "is one tick late", "the input a"),
        (2.0 * A, "is missing", "the term of soft.on"),
        (2.0 * A + 0.3 * late(B**2), "is one tick late", "the term of soft.on"),
        (-2.0 * A + 0.3 * B**2, "has the other sign", "the input a"),
        (2.0 * B + 0.3 * A**2, "are swapped", "the inputs a and b"),
        (1.7 * A + 0.3 * B**2, "is 1.7 instead of 2", "the parameter soft.gain"),
    ],
)
def test_each_fault_is_found_by_its_kind_and_place(y, kind, where):
    own = study(y[:, None])

    fault = software_fault(own, {}, replay(TABLE, {"soft.gain": 2.0, "soft.on": 1.0}))

    assert (fault.kind, fault.where, fault.is_exact) == (kind, where, True)
    assert fault.after < 1e-3 * fault.before


def test_a_part_that_replays_to_rounding_has_none():
    assert software_fault(study(RIGHT[:, None]), {}, RIGHT[:, None]) is None


def test_a_fault_of_no_kind_that_is_tried_is_told_with_what_the_nearest_leaves():
    y = RIGHT + np.sin(np.arange(N))

    fault = software_fault(study(y[:, None]), {}, RIGHT[:, None])

    assert not fault.is_exact
    assert fault.before == pytest.approx(np.sqrt(0.5), rel=0.02)
    assert "comes nearest and leaves" in str(fault)


@pytest.mark.parametrize(("period", "found"), [(1e-3, []), (2e-3, ["soft"]), (5e-4, [])])
def test_software_that_ticks_between_the_rows_cannot_be_judged(period, found):
    model = SimpleNamespace(sample_time="sample_time", n_continuous=0)
    description = SimpleNamespace(by_name={"sample_time": SimpleNamespace(start="0.001")})
    system = SimpleNamespace(model=lambda fmu: model, values={"soft": {}}, descriptions={"soft": description})
    bench = SimpleNamespace(part=SimpleNamespace(fmus=("soft",)), period=period)

    assert ticks_between_rows(SimpleNamespace(bench=bench, system=system)) == found


def test_rows_that_a_logger_dropped_are_no_fault(monkeypatch):
    """Every 400th row of an input was recorded as it was before; the software read what was true."""
    recorded = TABLE.copy()
    recorded[400::400, 0] = recorded[399:-1:400, 0]
    measured = RIGHT[:, None]
    monkeypatch.setattr(sys.modules[__name__], "TABLE", recorded)
    predicted = replay(recorded, {"soft.gain": 2.0, "soft.on": 1.0})

    assert unknown_rows(study(measured), {}, predicted).startswith("0.2 % of the rows do not replay")


@pytest.mark.parametrize(("at", "is_dropped"), [([10, 1500], True), ([1500], True), ([1500], False)])
def test_software_that_remembers_a_dropped_row_for_long_has_no_fault(monkeypatch, at, is_dropped):
    """It smooths over 8 rows; a row that was dropped before the replay has settled shows as well."""
    recorded = TABLE.copy()
    if is_dropped:
        recorded[at, 0] = recorded[np.array(at) - 1, 0]
    true = TABLE[:, 0].copy()
    if not is_dropped:
        true[at] += 1.0
    monkeypatch.setattr(sys.modules[__name__], "TABLE", recorded)
    measured, predicted = (lfilter([0.125], [1.0, -0.875], a)[:, None] for a in (true, recorded[:, 0]))

    assert bool(unknown_rows(study(measured), {}, predicted)) is is_dropped


def test_what_rings_on_from_before_the_first_row_is_no_fault():
    """It has fallen below rounding after some 100 of 2000 rows."""
    k = np.arange(N)
    ringing = 50.0 * 0.88**k * np.cos(0.3 * k)

    assert unknown_rows(study((RIGHT + ringing)[:, None]), {}, RIGHT[:, None])
    assert not unknown_rows(study((RIGHT + np.roll(ringing, 1000))[:, None]), {}, RIGHT[:, None])


def test_a_rare_fault_in_rows_that_were_recorded_is_none_of_the_recording():
    measured = RIGHT[:, None].copy()
    measured[400::400] += 5.0

    assert not unknown_rows(study(measured), {}, RIGHT[:, None])


@pytest.mark.parametrize("second_moves", [True, False])
def test_what_a_short_print_leaves_is_rounding_and_more_is_not(monkeypatch, second_moves):
    """Everything in steps of 0.1; then an output that is late as well. What does not move has no steps."""
    true = TABLE if second_moves else np.column_stack([A, np.zeros(N)])
    printed = 0.1 * np.round(true / 0.1)
    monkeypatch.setattr(sys.modules[__name__], "TABLE", printed)
    values = {"soft.gain": 2.0, "soft.on": 1.0}
    right = replay(true, values)[:, 0]
    predicted = replay(printed, values)

    assert "printed short" in unknown_rows(study(0.1 * np.round(right / 0.1)[:, None]), {}, predicted)
    assert not unknown_rows(study(0.1 * np.round(late(right) / 0.1)[:, None]), {}, predicted)


def test_a_difference_of_two_printed_columns_has_the_rounding_of_both(monkeypatch):
    """What is compared is a column in steps of 0.1 less the input b in steps of 1e-4: multiples of 1e-4."""
    table = np.column_stack([A, 0.01 * B])
    printed = 1e-4 * np.round(table / 1e-4)
    monkeypatch.setattr(sys.modules[__name__], "TABLE", printed)
    values = {"soft.gain": 2.0, "soft.on": 1.0}
    right = replay(table, values)[:, 0]
    measured = (0.1 * np.round((right + table[:, 1]) / 0.1) - printed[:, 1])[:, None]
    predicted = replay(printed, values)

    assert not unknown_rows(study(measured), {}, predicted)
    assert "printed short" in unknown_rows(study(measured), {}, predicted, {"y": "b"})
