"""FMUs that set the floating-point mode, or say something in each step."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.recording.files import read_csv

from .build import FOLDERS, HERE, compile_c, write_fmu

NOTHING, FLUSH_TO_ZERO, ROUND_UP, TRAP, LOG = range(5)
OUTPUTS = ("chaos", "small", "quotient", "memory")
SYSTEM = """\
name: rude
step_size: 0.001
stop_time: {stop}
fmus:
  rude: {{source: rude.fmu, parameters: {{deed: {deed}}}}}
  victim: {{source: rude.fmu}}
  probe: {{source: rude.fmu}}
coupling: {{order: [{order}]}}
connections: [{{from: victim.chaos, to: probe.input, factor: 0.1}}]
"""


def described():
    signals = [
        *((name, i, "output", "") for i, name in enumerate(OUTPUTS)),
        ("input", 4, "input", ' start="0"'),
        ("echo", 5, "output", ""),
    ]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{i}" causality="{causality}">'
        f"<Real{start}/></ScalarVariable>"
        for name, i, causality, start in signals
    )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="rude" guid="rude">
  <CoSimulation modelIdentifier="rude"/>
  <ModelVariables>
    {variables}
    <ScalarVariable name="deed" valueReference="9" causality="parameter" variability="fixed">
      <Integer start="0"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_c("2.0", tmp_path_factory.mktemp("rude"), HERE / "rude2.c", "-lm")


@pytest.fixture
def run(library, tmp_path):
    """Run the system; returns the rows and the summary."""

    def call(deed, order, stop):
        write_fmu(tmp_path / "rude.fmu", described(), {f"{FOLDERS['2.0']}/rude.so": library})
        system, out = tmp_path / "system.yaml", tmp_path / "out"
        system.write_text(SYSTEM.format(deed=deed, order=order, stop=stop))
        result = CliRunner().invoke(main, ["run", str(system), "--json", "--output", str(out)])
        assert result.exit_code == 0, result.output
        return read_csv(out / "result.csv"), json.loads((out / "summary.json").read_text())

    return call


@pytest.mark.parametrize("order", ["rude, victim, probe", "victim, probe, rude"])
@pytest.mark.parametrize("deed", [FLUSH_TO_ZERO, ROUND_UP, TRAP])
def test_the_mode_that_an_fmu_sets_reaches_no_bit_of_another_one_or_of_a_wire(run, deed, order):
    alone, _ = run(NOTHING, order, 0.5)
    rows, summary = run(deed, order, 0.5)

    for name in ("victim.chaos", "victim.small", "victim.quotient", "probe.echo"):
        assert np.array_equal(rows[name], alone[name]), name
    small = rows["victim.small"]
    assert np.any((small > 0.0) & (small < np.finfo(float).tiny))
    said = [m for m in summary["messages"] if m["category"] == "floating point"]
    assert {(m["fmu"], m["t"]) for m in said} == {("rude", 0.0)}


def test_memory_stays_flat_with_a_message_a_step(run):
    rows, summary = run(LOG, "rude, victim, probe", 30.0)
    kilobytes = rows["rude.memory"]

    assert sum(m["count"] for m in summary["messages"] if m["fmu"] == "rude") == 30_000
    assert kilobytes[10_000] > 0.0
    assert kilobytes[-1] - kilobytes[10_000] <= 1024.0
