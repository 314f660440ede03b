"""What a system as one FMU cannot do is refused by name, with exit status 2, and nothing is written."""

from __future__ import annotations

import json

import yaml
from click.testing import CliRunner

from master.cli import main
from tests.master.fuse.systems import MEMBERS, loop


def refused(folder, data) -> list[str]:
    path = folder / "system.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    done = CliRunner().invoke(main, ["export-fmu", str(path), "--output", str(folder / "loop.fmu"), "--json"])

    assert done.exit_code == 2, done.output
    assert not (folder / "loop.fmu").exists()
    return json.loads(done.stdout)["problems"]


def test_an_event_that_sets_what_an_input_of_the_system_leads_to_is_refused(tmp_path):
    data = loop(MEMBERS, free={"source": "spacecraft"})
    data["coupling"]["order"] = [*MEMBERS, "free"]
    data["connectors"] = {"whole.u": {"kind": "input", "type": "real"}}
    data["connections"].append({"from": "whole.u", "to": "free.f"})
    data["events"] = [{"at": 0.1, "set": {"whole.u": 3.0}}]

    [problem] = refused(tmp_path, data)
    assert problem.startswith("events[0]: an event that sets an input of the system itself, got free.f")


def test_connectors_that_an_fmu_cannot_have_are_refused_by_name(tmp_path):
    data = loop(MEMBERS, free={"source": "spacecraft"})
    data["coupling"]["order"] = [*MEMBERS, "free"]
    data["connectors"] = {
        "whole.m": {"kind": "parameter", "type": "real", "start": 700},
        "whole.u": {"kind": "input", "type": "real"},
    }
    data["connections"] += [
        {"from": "whole.m", "to": "free.m_s"},
        {"from": "whole.u", "to": "free.f", "factor": 0.0},
    ]

    parameter, start, target = refused(tmp_path, data)
    assert parameter.startswith("connectors: a parameter of the system itself, got whole.m")
    what = "no value from which all that it leads to start as they do"
    assert start.startswith(f"connectors: {what}, got whole.u")
    what = "an input of the system itself leads to what is no input"
    assert target.startswith(f"connectors: {what}, got free.m_s")


def test_a_tick_of_too_many_operations_is_refused(tmp_path):
    data = loop([{"waveform": MEMBERS, "window": 3000}], stop=3.0)

    [problem] = refused(tmp_path, data)
    assert problem.startswith("coupling.order: too many operations in a tick, got ")
