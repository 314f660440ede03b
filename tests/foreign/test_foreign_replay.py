"""A foreign FMU in a diagnosis: rows of its inputs and of its outputs belong together."""

import numpy as np
import pytest

from master.diagnosis.answer.answer import answer
from master.diagnosis.case.case import load_case
from master.diagnosis.case.cut import cut
from master.diagnosis.replay.replayer import Link, Player
from master.fmi.description_reader import read_description
from tests.foreign.build import describe_2
from tests.foreign.foreign import COMPILED

pytestmark = COMPILED

CASE = """name: foreign
fmus: {s: {source: ./types2.fmu}}
recordings: {a: run.csv}
time: {column: t}
signals: {u: {column: u}, y: {column: y}}
inputs: {s.Real_in: INPUT}
set: {s.Integer_in: 0, s.Enumeration_in: low, s.Boolean_in: false}
compared: {s.Real_out: y}
split: {blocks: [fit, select, sealed], guard: 0.0}
"""


def row_taken(folder, given="u"):
    rows = "".join(f"{0.1 * i:.1f},{i},{i}\n" for i in range(30))
    (folder / "run.csv").write_text("t,u,y\n" + rows)
    (folder / "case.yaml").write_text(CASE.replace("INPUT", given))
    [part] = cut(load_case(folder / "case.yaml")).parts
    [(_, at)] = part.columns
    return at


def structured(dependencies):
    outputs = f'<Outputs><Unknown index="2" {dependencies}/></Outputs>'
    return describe_2().replace("<ModelStructure/>", f"<ModelStructure>{outputs}</ModelStructure>")


@pytest.mark.parametrize(
    ("dependencies", "row"), [("", "end"), ('dependencies="1"', "end"), ('dependencies=""', "start")]
)
def test_an_output_that_may_follow_its_input_at_once_is_compared_in_its_row(fmu, tmp_path, dependencies, row):
    fmu("2.0", structured(dependencies))

    assert row_taken(tmp_path) == row


LAGGING = CASE.replace("[fit, select, sealed]", "[fit, select, fit, select, sealed]")


def diagnosed(folder, given, noise, lag):
    """The verdict on y[k] = u[k - lag] + noise, for an FMU whose output is its input."""
    generator = np.random.default_rng(5)
    u = np.cumsum(generator.standard_normal(1200))
    y = u[1 - lag : len(u) - lag] + noise * generator.standard_normal(len(u) - 1)
    pairs = np.column_stack([u[1:], y]).tolist()
    rows = "".join(f"{0.1 * i:.1f},{a!r},{b!r}\n" for i, (a, b) in enumerate(pairs))
    (folder / "run.csv").write_text("t,u,y\n" + rows)
    (folder / "case.yaml").write_text(LAGGING.replace("INPUT", given))
    report = answer(folder / "case.yaml", folder / "results", lambda text: None)
    return report["verdict"], report["sentence"], report["changed_rows"]


@pytest.mark.parametrize(
    ("dependencies", "lag", "noise"),
    [
        ("", 0, 0.0),
        ("", 1, 0.0),
        ("", 1, 0.01),
        ('dependencies="1"', 1, 0.0),
        ('dependencies=""', 0, 0.0),
        ('dependencies=""', 1, 0.0),
    ],
)
def test_a_lag_of_one_row_is_found_and_named_whatever_the_fmu_says(fmu, tmp_path, dependencies, lag, noise):
    fmu("2.0", structured(dependencies))
    found, said, changed = diagnosed(tmp_path, "u", noise, lag)
    row = "start" if lag else "end"
    usual = "start" if dependencies == 'dependencies=""' else "end"

    assert found == "nothing missing"
    assert changed == ({} if row == usual else {"s.Real_in": row})
    assert (f"s.Real_in at the {row} of each step" in said) == bool(changed)


def test_the_row_that_the_case_names_counts(fmu, tmp_path):
    fmu("2.0")

    assert row_taken(tmp_path, "{signal: u, at: start}") == "start"


def test_a_replay_of_an_output_that_follows_its_input_is_exact(fmu):
    measured = np.sin(np.arange(11.0))[:, None]
    player = Player([Link("s", read_description(fmu("2.0")), {"Real_in": 0}, {}, ("Real_out",))])
    rows = player.play({}, measured, (0, 10), 0.1)
    player.close()

    assert rows[1:].tolist() == measured[1:].tolist()
