"""Recordings of a part: tables of inputs, segments, rows, start values; a formula is the FMU."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.case.cut import CutPart, MeasuredInput
from master.diagnosis.data.recordings import Recording
from master.diagnosis.replay.replay_bench import ReplayBench, Segment

H = 1e-2
RATE = 0.5  # 1/s, of the decay


class Decay:
    """y' = u - RATE y from y0, with the input of each step's row held over it: exact steps."""

    names = ("box.y", "box.u_seen")

    def __init__(self):
        description = SimpleNamespace(by_name={"y": None, "y0": None})
        self.chain = [SimpleNamespace(name="box", description=description)]
        self.calls = []

    def play(self, values, data, segment, step, every=1):
        first, n = segment
        self.calls.append((segment, step, every))
        q = np.exp(-RATE * step)
        y = values["box"].get("y0", 0.0)
        rows = [(y, data[first, 0])]
        for j in range(n):
            u = data[first + j + 1, 0]
            y = q * y + (1.0 - q) / RATE * u
            if (j + 1) % every == 0:
                rows.append((y, u))
        return np.array(rows)


def recording(name, n, u, y0=0.0):
    """A recording of the decay under an input that is held: shape (n,)."""
    q = np.exp(-RATE * H)
    y = [y0]
    for k in range(n - 1):
        y.append(q * y[-1] + (1.0 - q) / RATE * u[k + 1])
    return Recording(name, np.arange(n) * H, {"u": np.asarray(u, dtype=float), "y": np.array(y)}, H)


def bench(recordings, row="end", starts=None, fitted=None, own=None, **options):
    part = CutPart(("box",), {"box": {"u": MeasuredInput("u", row)}}, {"box": {}}, {"box.y": "y"})
    replay = {"oversample": 1, "settle": 0.0, "windows": {}, "cut": 0, "decimate": 1} | options
    case = SimpleNamespace(
        replay=SimpleNamespace(**replay),
        starts=starts or {},
        per_recording=tuple(own or ()),
        refit={key: SimpleNamespace(low=low, high=high) for key, (low, high) in (own or {}).items()},
    )
    return ReplayBench(part, {r.name: r for r in recordings}, case, fitted)


def test_replay_of_what_a_linear_system_gave_is_that():
    rng = np.random.default_rng(1)
    one, two = recording("one", 300, rng.standard_normal(300)), recording("two", 50, np.ones(50))
    own = bench([one, two])

    predicted = own.predict(Decay(), {"box": {}})

    assert predicted.shape == (350, 1)
    assert np.abs(predicted - own.measured).max() < 1e-12
    assert predicted[299 + 50, 0] == pytest.approx((1.0 - np.exp(-RATE * 49 * H)) / RATE)


@pytest.mark.parametrize(("row", "seen"), [("end", [0, 1, 2, 3]), ("start", [0, 0, 1, 2])])
def test_a_step_takes_the_row_at_its_end_or_at_its_start(row, seen):
    r = recording("r", 4, [0.0, 1.0, 2.0, 3.0])

    assert bench([r], row).record(Decay(), {"box": {}})["box.u_seen"].tolist() == seen


def test_more_steps_than_rows_are_driven_by_a_cubic():
    """Four points of a cubic give the cubic between them; the player is told the smaller step."""
    t = np.arange(4) * H
    r = Recording("r", t, {"u": (t / H) ** 3, "y": t}, H)
    own = bench([r], oversample=4)
    player = Decay()
    own.predict(player, {"box": {}})

    assert own.data["r"][:, 0] == pytest.approx((np.arange(13) / 4.0) ** 3, abs=1e-12)
    assert player.calls == [((0, 12), H / 4, 4)]


def test_windows_start_again_and_rows_while_they_settle_are_not_in_use():
    r = recording("r", 100, np.ones(100))
    own = bench([r], windows={"box": 30 * H, "other": H}, settle=5 * H)

    assert own.segments == [Segment("r", 0, 30), Segment("r", 30, 60), Segment("r", 60, 100)]
    assert np.flatnonzero(~own.in_use).tolist() == [*range(5), *range(30, 35), *range(60, 65)]


def test_rows_are_cut_at_both_ends_and_decimated():
    own = bench([recording("a", 100, np.zeros(100)), recording("b", 61, np.zeros(61))], cut=10, decimate=4)

    assert own.lengths == {"a": 20, "b": 11}
    assert own.begin("b") == 20
    assert own.first_sample("b") == 100
    assert own.row_period == 4 * H
    assert own.compared_rows(np.arange(161.0)).tolist() == [*range(10, 90, 4), *range(110, 151, 4)]
    assert own.times[[0, 99, 100, 160]].tolist() == pytest.approx([0.0, 99 * H, 0.0, 60 * H])


def test_a_fit_sees_its_recordings_only():
    one, two = recording("one", 40, np.ones(40)), recording("two", 40, np.ones(40))
    own = bench([one, two], fitted={"two"})

    seen = own.predict(Decay(), {"box": {}}, everything=False)

    assert np.isnan(seen[:40]).all()
    assert np.array_equal(seen[40:], own.measured[40:])


def test_a_start_value_that_was_not_measured_is_estimated_where_none_is_given():
    """Of the recording that is fitted on the fit gives it; the other begins elsewhere."""
    u = np.zeros(200)
    own = bench(
        [recording("one", 200, u, y0=0.7), recording("two", 200, u, y0=-0.4)],
        starts={"box.y0": (-1.0, 1.0), "other.x": (0.0, 1.0)},
        fitted={"one"},
    )
    player = Decay()

    assert own.starts_of(player) == ["box.y0"]
    assert own.estimated(player, {"box": {}})["box.y0"] == pytest.approx(0.7, abs=1e-4)
    predicted = own.predict(player, {"box": {"y0": 0.7}})
    assert predicted[0, 0] == 0.7
    assert predicted[200, 0] == pytest.approx(-0.4, abs=1e-4)


def test_start_values_of_each_window_are_estimated_by_steps():
    r = recording("r", 90, np.sin(np.arange(90) / 5.0), y0=0.3)
    own = bench([r], windows={"box": 30 * H}, starts={"box.y0": (-1.0, 1.0)})

    assert own.predict(Decay(), {"box": {}}) == pytest.approx(own.measured, abs=1e-9)


class Scaled(Decay):
    """The same, which begins at k times its start value."""

    def play(self, values, data, segment, step, every=1):
        own = values["box"]
        return super().play({"box": {"y0": own.get("k", 1.0) * own["y0"]}}, data, segment, step, every)


def test_derivatives_by_start_values_serve_until_they_no_longer_hold():
    """A window takes middle, a moved start, a step, the answer; less the second, or a step in vain more."""
    r = recording("r", 90, np.sin(np.arange(90) / 5.0), y0=0.3)
    own = bench([r], windows={"box": 30 * H}, starts={"box.y0": (-1.0, 1.0)})
    player = Scaled()
    replays = []
    for k in (1.0, 1.0, 3.0, 3.0):
        before = len(player.calls)
        assert own.predict(player, {"box": {"k": k}}) == pytest.approx(own.measured, abs=1e-9)
        replays.append(len(player.calls) - before)

    assert replays == [3 * n for n in (4, 3, 5, 3)]


def test_a_value_that_a_recording_sets_holds_in_it_alone():
    one = recording("one", 100, np.zeros(100), y0=1.0)
    two = replace(recording("two", 100, np.zeros(100), y0=3.0), given={"box.y0": 3.0})
    found = bench([one, two])

    assert np.abs(found.predict(Decay(), {"box": {"y0": 1.0}}) - found.measured).max() < 1e-12


def test_each_recording_has_its_own_value_of_a_parameter_and_one_that_no_fit_sees_finds_it_on_its_head():
    starts = {"one": 1.0, "two": 3.0, "sealed": -2.0}
    recordings = [recording(name, 100, np.zeros(100), y0) for name, y0 in starts.items()]
    found = bench(recordings, fitted={"one", "two"}, own={"box.y0": (-10.0, 10.0)})
    values = {"box": {"y0": 0.0, "y0@one": 1.0, "y0@two": 3.0}}
    player = Decay()
    predicted = found.predict(player, values)

    assert np.abs(predicted - found.measured).max() < 1e-9
    on_head = [n for segment, *_ in player.calls if (n := segment[1]) < 99]
    assert set(on_head) == {14}


class Begun(Decay):
    """The same, which begins at the sum of two start values, the second three times as heavy."""

    def __init__(self):
        super().__init__()
        self.chain[0].description.by_name["y1"] = None

    def play(self, values, data, segment, step, every=1):
        own = values["box"]
        both = own.get("y0", 0.0) + 3.0 * own.get("y1", 0.0)
        return super().play({"box": {"y0": both}}, data, segment, step, every)


@pytest.mark.parametrize(("player", "keys"), [(Decay(), ["box.y0"]), (Begun(), ["box.y0", "box.y1"])])
def test_start_values_of_a_recording_that_no_fit_sees_depend_on_its_head_alone(player, keys):
    """What is measured after the first 15 % may be anything; those rows are marked, no other."""
    one = recording("one", 200, np.zeros(200), y0=-0.4)
    other = replace(one, signals=one.signals | {"y": np.where(np.arange(200) < 30, one["y"], 9.0)})
    found = [bench([r], starts=dict.fromkeys(keys, (-1.0, 1.0)), fitted=set()).afresh() for r in (one, other)]

    # each output is taken over its deviation, which the rows afterwards change: so only nearly the same
    first, second = (b.predict(player, {"box": {}}) for b in found)

    assert second == pytest.approx(first, abs=1e-4)
    for own in found:
        assert np.flatnonzero(own.looked_at()).tolist() == list(range(30))
        (estimated,) = own.estimates.values()
        assert estimated.names == tuple(keys)


def test_start_values_of_a_recording_that_is_fitted_are_found_on_all_samples_and_take_none_from_a_score():
    r = recording("r", 200, np.zeros(200), y0=-0.4)
    own = bench([r], starts=dict.fromkeys(["box.y0", "box.y1"], (-1.0, 1.0)))
    player = Begun()

    guess = own.estimated(player, {"box": {}})
    assert guess["box.y0"] + 3.0 * guess["box.y1"] == pytest.approx(-0.4, abs=1e-5)
    for found in (own, own.afresh()):
        assert found.predict(player, {"box": {}}) == pytest.approx(own.measured, abs=1e-5)
        assert not found.looked_at().any()


def test_rows_on_which_a_recording_found_its_parameter_are_marked_and_those_of_a_bench_afresh_are_not():
    recordings = [recording(name, 100, np.zeros(100), 1.0) for name in ("one", "sealed")]
    found = bench(recordings, fitted={"one"}, own={"box.y0": (-10.0, 10.0)})
    found.predict(Decay(), {"box": {"y0": 0.0, "y0@one": 1.0}})

    assert np.flatnonzero(found.looked_at()).tolist() == list(range(100, 115))
    assert not found.afresh().looked_at().any()


def test_the_nominal_values_hold_in_all_recordings_where_nothing_was_fitted():
    recordings = [recording(name, 100, np.zeros(100), 1.0) for name in ("one", "two")]
    found = bench(recordings, own={"box.y0": (-10.0, 10.0)})

    assert found.predict(Decay(), {"box": {"y0": 5.0}})[[0, 100], 0].tolist() == [5.0, 5.0]
