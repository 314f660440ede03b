"""`check` and `explain` say what is wrong with a system and load no FMU, whatever is to be designed."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.errors import ConfigError
from master.experiment.prepare import prepare
from master.fmi.fmi2 import Fmi2Slave
from master.fmi.fmi3 import Fmi3Slave

CONFIGS = Path(__file__).parents[2] / "configs"
WITH_LEAD = sorted(
    path for path in CONFIGS.rglob("*.yaml") if "design: auto" in path.read_text(encoding="utf-8")
)
LEAD = "dpdc: {design: auto"


@pytest.fixture(autouse=True)
def nothing_is_loaded(monkeypatch):
    def refuse(*arguments, **options):
        raise AssertionError("an FMU is loaded")

    monkeypatch.setattr(Fmi2Slave, "__init__", refuse)
    monkeypatch.setattr(Fmi3Slave, "__init__", refuse)


def test_a_run_loads_fmus():
    with pytest.raises(AssertionError, match="an FMU is loaded"):
        prepare_to_run(WITH_LEAD[0])


def test_some_configurations_have_a_lead_to_design():
    assert WITH_LEAD


@pytest.mark.parametrize("command", ["check", "explain"])
@pytest.mark.parametrize("path", WITH_LEAD, ids=lambda path: "-".join(path.parts[-2:]))
def test_no_fmu_is_loaded(command, path):
    done = CliRunner().invoke(main, [command, str(path), "--set", "compensator.dpdc=true"])

    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("wish", "fault"),
    [
        (", fmu: compensatr}", "dpdc.fmu: no such FMU, got 'compensatr', expected 'compensator' (of "),
        (", fmu: spacecraft}", "dpdc: no phase lead in spacecraft, got no dpdc, dpdc_phase, dpdc_frequency"),
        (", ranges: {m_s: [900, 100]}}", "dpdc: no range of m_s, got (900.0, 100.0), expected positive "),
        (", ranges: {m_x: [1, 2]}}", "dpdc.ranges.m_x: not one of the choices, got 'm_x', expected 'm_s', "),
        (", amplitude: plant}", "dpdc.amplitude: two rules for one gain, got plant and another "),
    ],
)
def test_what_a_design_lacks_is_said_with_its_line(tmp_path, wish, fault):
    text = WITH_LEAD[0].read_text(encoding="utf-8").replace("fmdc: false", "gain_convention: unit_dc")
    head, _, tail = text.partition(LEAD)
    path = tmp_path / "system.yaml"
    path.write_text(head + LEAD + wish + tail[tail.index("\n") :], encoding="utf-8")
    line = head.count("\n") + 1
    with pytest.raises(ConfigError) as caught:
        prepare(path)

    assert any(p.startswith(f"{path}:{line}: {fault}") for p in caught.value.problems), caught.value.problems
