"""What is saved, the page of a run, and the system as a picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from master.recording.recorder import Result
from master.recording.selection import SelectedRows, Selection
from master.runs.diagram import boxes, input_line

CONFIGS = Path(__file__).parents[3] / "configs"
TEXT = """\
name: test
step_size: 0.5
stop_time: 20.0
fmus:
  clock: {source: clock.fmu}
  mass: {source: integrator.fmu, parameters: {size: 1.0}}
coupling: {order: [mass, clock]}
connections:
  - {from: clock.t, to: mass.u}
"""


def result(n=7):
    values = np.column_stack([np.arange(n), 10.0 * np.arange(n), 100.0 * np.arange(n)])
    return Result(0.5 * np.arange(n), ("a.x", "a.y", "b.z"), ("m", "N", "m"), values)


def test_a_selection_keeps_signals_in_their_order_and_every_nth_row_from_the_first():
    chosen = Selection(("b.z", "a.x"), 3).of(result())

    assert (chosen.names, chosen.units) == (("b.z", "a.x"), ("m", "m"))
    assert chosen.time.tolist() == [0.0, 1.5, 3.0]
    assert chosen.values.tolist() == [[0.0, 0.0], [300.0, 3.0], [600.0, 6.0]]


@pytest.mark.parametrize("sizes", [(7,), (1, 1, 1, 1, 1, 1, 1), (2, 5), (4, 2, 1)])
def test_rows_that_come_in_blocks_are_selected_as_one(sizes):
    class Kept:
        times: list = []  # noqa: RUF012  # one test, one list

        def write(self, rows):
            self.times = [*self.times, *rows.time.tolist()]

    sink, first, whole = Kept(), 0, result()
    rows = SelectedRows(Selection((), 3), sink)
    for n in sizes:
        part = slice(first, first + n)
        rows.write(Result(whole.time[part], whole.names, whole.units, whole.values[part]))
        first += n

    assert sink.times == [0.0, 1.5, 3.0]


def test_options_take_the_place_of_the_section(bay):
    text = TEXT + "record: {signals: mass.x, every: 4}\n"
    path = bay.write(text)

    assert prepare(path).selection == Selection(("mass.x",), 4)
    assert prepare(path, Request(record=("clock.t",))).selection == Selection(("clock.t",), 4)
    assert prepare(path, Request(every=2)).selection == Selection(("mass.x",), 2)
    assert prepare(bay.write(TEXT)).selection.is_all


def test_names_that_are_no_outputs_are_told_at_once_with_the_nearest(bay):
    text = TEXT + "record: {signals: [mass.xx, mass.u]}\nplots: [[clock.tt]]\n"
    with pytest.raises(ConfigError) as caught:
        prepare(bay.write(text))

    faults = [(p.got, p.expected.partition(" (")[0]) for p in caught.value.problems]
    assert [got for got, _ in faults] == ["'mass.xx'", "'mass.u'", "'clock.tt'"]
    assert (faults[0][1], faults[2][1]) == ("'mass.x'", "'clock.t'")


def test_a_run_saves_what_is_recorded(bay):
    out = bay.folder / "out"
    path = bay.write(TEXT)
    done = CliRunner().invoke(
        main, ["run", str(path), "--output", str(out), "--record", "clock.t", "--every", "20"]
    )

    assert done.exit_code == 0
    assert (out / "result.csv").read_text(encoding="utf-8") == '"time","clock.t"\n0,0\n10,10\n20,20\n'


def test_the_diagram_lists_the_wires_with_the_ages_of_the_ledger():
    experiment = prepare(CONFIGS / "low_frequency.yaml")
    placed = boxes(experiment)

    assert [box.name for box in placed] == [m for group in experiment.schedule.members for m in group]
    lines = [input_line(e) for box in placed for e in box.inputs]
    assert len(lines) == len(experiment.ledger.entries) == 9
    assert "f_mea  from  force_sensor.f_mea:  1 step, 1 ms" in lines


def test_a_page_and_a_picture_are_written_and_the_page_is_small(tmp_path):
    runner = CliRunner()
    out = tmp_path / "out"
    config = str(CONFIGS / "low_frequency.yaml")
    done = runner.invoke(main, ["run", config, "--page", "--output", str(out), "--json"])
    page = (out / "run.html").read_text(encoding="utf-8")

    assert json.loads(done.stdout)["files"]["page"] == str(out / "run.html")
    assert len(page) <= 2_500_000
    for said in ("spacecraft.m_s", "sha256", "force_sensor.seed", "zeta"):
        assert said in page
    drawn = runner.invoke(main, ["show", config, "--output", str(tmp_path / "system.svg")])
    assert drawn.exit_code == 0
    assert "contact.f_act" in (tmp_path / "system.svg").read_text(encoding="utf-8")
    assert runner.invoke(main, ["show", config, "--output", "x.pdf"]).exit_code == 2
