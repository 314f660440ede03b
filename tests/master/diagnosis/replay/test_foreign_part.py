from __future__ import annotations

import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from master import catalogue
from master.diagnosis.answer.replayed import replay
from master.diagnosis.case.case import read_case
from master.diagnosis.case.cut import MeasuredInput, cut
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.replay.candidate_models import ModelPool
from master.diagnosis.replay.fitting_effects import candidates
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.replay.slot_signals import slot_signals
from master.errors import ConfigError


def test_what_drives_a_foreign_file_is_there_to_be_tested():
    push = np.arange(5.0)
    part = SimpleNamespace(fmus=("box",), inputs={"box": {"u": MeasuredInput("push", "end")}})
    bench = SimpleNamespace(part=part, record=lambda *_: {"box.y": push}, signal={"push": push}.get)
    system = SimpleNamespace(model=lambda _: None)

    assert slot_signals(system, bench, None, {}) == {"box.u": {"value": push}}


N = 400
T = 0.01 * np.arange(N)
SPEED = 0.02 * np.sin(3.0 * T)
DAMPING = 203.5  # N s/m, of the foreign file
SYSTEM = """
name: rig
stop_time: 1.0
fmus:
  before: {source: static_follower}
  box: {source: ./box.fmu}
  after: {source: static_follower}
connections:
  - {from: before.y, to: box.der_q, units: ignored, factor: 2}
  - {from: box.force, to: after.u, units: ignored, offset: 5}
"""
CASE = """
name: rig
system: rig.yaml
recordings: {run: run.csv}
time: {column: t, unit: s}
signals:
  speed: {column: speed, unit: "1"}
  none: {column: none, unit: "1"}
  force: {column: force, unit: "1"}
inputs: {before.u: speed, box.q: none, box.der_der_q: none}
compared: {after.y: force}
split: {blocks: [fit, select, sealed], guard: 0.1}
"""


def written(folder, system=SYSTEM, speed=SPEED):
    """A case of a foreign file, an inverse axis, between two followers that have slots."""
    target = {"box": catalogue.locate("servo_axis_inverse", folder, "native")}
    shutil.copy(catalogue.files(target, catalogue.silent)["box"], folder / "box.fmu")
    (folder / "rig.yaml").write_text(system, encoding="utf-8")
    (folder / "case.yaml").write_text(CASE, encoding="utf-8")
    rows = "\n".join(f"{t:.2f},{v:.9f},{407.0 * v + 5.0:.9f},0" for t, v in zip(T, speed, strict=True))
    (folder / "run.csv").write_text(f"t,speed,force,none\n{rows}\n", encoding="utf-8")
    return folder / "case.yaml"


def test_followers_around_a_foreign_file_give_it_slots_and_cost_no_time(tmp_path):
    """By hand: 203.5 N s/m times twice the speed of the same row, and 5, as the wires say."""
    case = written(tmp_path)
    (found,) = replay(case).values()
    loaded = read_case(case)
    system = cut(loaded)
    (part,) = system.parts

    assert found.predicted[:, 0] == pytest.approx(2.0 * DAMPING * SPEED + 5.0, abs=1e-6)
    with ModelPool(system, part) as pool:
        bench = ReplayBench(part, opened(loaded)[1], loaded.case)
        signals = slot_signals(system, bench, pool.player(()), system.values)
    assert signals["after.answer"]["value"] == pytest.approx(found.predicted[:, 0], abs=1e-9)
    places = {e.place for e in candidates(system, part, {})}
    assert places == {"before.answer", "after.answer"}


def test_a_law_with_memory_after_a_foreign_file_sees_its_output_between_the_rows(tmp_path):
    """By hand: a ramp of 1/s that lags by 50 ms; held over each row it would come half a row, 5 ms, apart."""
    ramp = T / 407.0
    lag = "{source: static_follower__answer_extra_lag, parameters: {answer_extra_lag_time_constant: 0.05}}"
    system = SYSTEM.replace("after: {source: static_follower}", f"after: {lag}")
    case = written(tmp_path, system, ramp)
    (found,) = replay(case).values()

    late = T - 0.05 * (1.0 - np.exp(-T / 0.05))
    assert found.predicted[:, 0] == pytest.approx(late + 5.0, abs=1e-6)


def test_a_port_that_carries_nothing_measured_has_no_slot(tmp_path):
    case = written(tmp_path)
    case.write_text(CASE + "slots: {box.der_q: all}\n", encoding="utf-8")

    with pytest.raises(ConfigError) as caught:
        cut(read_case(case))
    assert "no slot at this port of a file, got 'der_q', expected a number that is named" in str(caught.value)


@pytest.mark.parametrize("key", ["delay", "extrapolation"])
def test_a_wire_that_waits_or_looks_ahead_is_refused_where_it_would_be_replayed_without(key, tmp_path):
    case = written(tmp_path, SYSTEM.replace("factor: 2", f"factor: 2, {key}: 1"))

    with pytest.raises(ConfigError) as caught:
        cut(read_case(case))
    assert "inputs: before.y -> box.der_q, got " in str(caught.value)
    assert "expected none in a wire that is replayed: name in `inputs`" in str(caught.value)
