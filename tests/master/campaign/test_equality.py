"""A run of a campaign has the bits of `dockloop run`, whatever went before it in its process."""

from __future__ import annotations

import json
import shlex

import numpy as np
import pyarrow.dataset as pads
import pytest
from click.testing import CliRunner

from master.campaign.plan import make_plan
from master.campaign.stepper import Stepper
from master.campaign.sweep import sweep
from master.campaign.systems import portable
from master.cli import main
from master.recording.files import read_csv
from master.text.yaml_lines import write_yaml

pytestmark = pytest.mark.slow

CAMPAIGN = """\
system: {system}
stop_time: 0.3
vary:
{vary}
design: {{method: random, size: {size}, seed: 5}}
keep: {{signals: all}}
"""
PLAIN = """\
  spacecraft.m_s: {uniform: [50, 900]}
  contact.k_p: {lognormal: [37760, 0.5]}
  compensator.dpdc: {choice: [true, false]}
  seed: {integers: [1, 1000]}
"""
STRUCTURAL = """\
  connections[contact.s_act].delay: {integers: [0, 3]}
  spacecraft.m_s: {uniform: [300, 900]}
"""
METHODS = "  method: {choice: [smith, paper_L]}\n"
ORDERS = """\
  coupling.order:
    choice:
      - [compensator, spacecraft, motion_simulator, contact, force_sensor, ideal]
      - [[compensator, spacecraft], motion_simulator, [contact, force_sensor], ideal]
"""


def written(tmp_path, vary, size, system="experiment"):
    path = tmp_path / "campaign.yaml"
    path.write_text(CAMPAIGN.format(vary=vary, size=size, system=system))
    return path


def same_bits(signals, rows):
    return all(
        np.array_equal(np.asarray(values), rows[name], equal_nan=True) for name, values in signals.items()
    )


@pytest.mark.parametrize(
    "vary",
    [
        PLAIN,
        STRUCTURAL,
        pytest.param(ORDERS, marks=pytest.mark.long),
        pytest.param(METHODS, marks=pytest.mark.long),
    ],
    ids=["plain", "structural", "orders", "methods"],
)
def test_a_run_has_the_bits_of_the_command_that_repeats_it(tmp_path, vary):
    plan = make_plan(written(tmp_path, vary, 4))
    stepper = Stepper(plan)
    rows = [stepper.row(run) for run in (3, 0, 2, 1)]
    stepper.close()
    for row in rows[-1:]:
        file = tmp_path / f"run-{row.run}.yaml"
        if plan.needs_file(row.run):
            file.write_text(write_yaml(portable(plan.varied.document(plan.values(row.run)))))
        out = tmp_path / f"out-{row.run}"
        words = shlex.split(plan.command(row.run, str(file)))[1:]
        done = CliRunner().invoke(main, [*words, "--stop-time", "0.3", "--output", str(out)])
        assert done.exit_code == 0, done.output
        summary = json.loads((out / "summary.json").read_text())

        assert same_bits(row.signals, read_csv(out / "result.csv"))
        assert {n: summary["metrics"][n] for n in row.numbers} == row.numbers


def test_workers_and_order_change_no_bit(tmp_path):
    plan = make_plan(written(tmp_path, PLAIN, 12))
    tables = []
    for n in (1, 3):
        sweep(plan, tmp_path / str(n), n, page=False)
        table = pads.dataset(tmp_path / str(n) / "runs").to_table().sort_by("run")
        tables.append(table.drop_columns(["wall_s", "stepping_s"]))

    assert tables[0].equals(tables[1])
