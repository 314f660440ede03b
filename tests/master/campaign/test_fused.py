"""A campaign whose system is compiled as one has the rows of one whose FMUs are apart, or says why not."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
import pyarrow.dataset as pads
import pytest
import yaml

from fmu_sources.export import native
from fmu_sources.export.native import NativeBuildError
from master import installation
from master.campaign import fused, proven
from master.campaign.fused import FUSED, Fusing
from master.campaign.plan import make_plan
from master.campaign.stepper import Stepper
from master.campaign.sweep import sweep
from master.fuse import runs as fused_runs
from master.fuse.runs import Draft, FusedForm, fused_form
from tests.master.fuse.systems import MEMBERS, loop

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="campaigns fork their runs, and say so elsewhere"
    ),
]

OTHERS = {"wall_s", "stepping_s"}


@pytest.fixture
def plan(tmp_path):
    """Plan runs of a loop of four FMUs: some pass a limit, some are refused by an FMU."""
    system = loop(MEMBERS, stop=0.3)
    system["compare"] = {"signal": "spacecraft.s_des", "reproduced": "motion_simulator.s_act", "offset": 0.01}
    system["limits"] = {"motion_simulator.v_act": 0.1}

    def planned(vary, of_system=None, **more):
        (tmp_path / "system.yaml").write_text(yaml.safe_dump(system | (of_system or {})))
        campaign = {
            "system": "system.yaml",
            "vary": vary,
            "keep": {
                "metrics": "all",
                "measures": {"work": {"energy": "contact.f_act", "with": "contact.x"}},
            },
        }
        path = tmp_path / "campaign.yaml"
        path.write_text(yaml.safe_dump(campaign | more))
        return make_plan(path)

    return planned


VARY = {
    "spacecraft.m_s": {"values": [820.0, 300.0, 0.0, 75.0, 500.0, 900.0]},
    "contact.k_p": {"values": [37900.0, 90000.0]},
}


def told(row):
    return row.status, row.message, row.t_end, row.steps, dict(row.numbers)


@pytest.mark.parametrize("signals", [{"contact.f_act": 7}, "all"], ids=["some", "all"])
def test_rows_of_the_fused_form_are_those_of_the_fmus_to_the_bit_and_word(plan, signals):
    planned = plan(VARY, keep={"metrics": "all", "measures": {"y": {"rms": "contact.x"}}, "signals": signals})
    runs = range(planned.sample.n_runs)
    apart = [Stepper(planned).row(run) for run in runs]
    stepper_of_form = Stepper(planned, fused_form(planned.base))
    rows = [stepper_of_form.row(run) for run in runs]

    assert {row.status for row in apart} == {"completed", "diverged", "failed"}
    assert [told(row) for row in rows] == [told(row) for row in apart]
    for one, other in zip(rows, apart, strict=True):
        assert list(one.signals) == list(other.signals)
        assert all(one.signals[n].tobytes() == other.signals[n].tobytes() for n in one.signals)
    assert rows[0].made == proven.FIRST
    assert {row.made for row in rows[1:] if row.status != "failed"} == {FUSED}
    assert {row.made for row in rows if row.status == "failed"} == {fused_runs.REFUSED}
    assert any(row.status == "diverged" and 10 < row.steps < 290 for row in rows)


def test_rows_of_a_system_under_events_are_those_of_the_fmus_too(plan):
    events = [
        {"at": 0.05, "set": {"spacecraft.m_s": 1500.0}, "for": 0.05},
        {"when": "contact.f_act > 20", "jitter": {"spacecraft.f": 3}, "seed": 5},
        {"when": "spacecraft.s_des > -0.005", "set": {"contact.k_p": 5000.0}, "for": 0.01},
    ]
    planned = plan(VARY, {"events": events}, keep={"metrics": "all", "signals": "all"})
    runs = range(planned.sample.n_runs)
    stepper_of_form = Stepper(planned, fused_form(planned.base))
    rows = [stepper_of_form.row(run) for run in runs]
    apart = [Stepper(planned).row(run) for run in runs]

    assert [told(row) for row in rows] == [told(row) for row in apart]
    assert FUSED in {row.made for row in rows}
    for one, other in zip(rows, apart, strict=True):
        assert all(one.signals[n].tobytes() == other.signals[n].tobytes() for n in other.signals)


def test_a_campaign_says_how_many_runs_were_fused_and_its_dataset_is_the_same(plan, tmp_path, monkeypatch):
    planned = plan({"spacecraft.m_s": {"values": np.linspace(900.0, 300.0, 40).tolist()}})
    few = sweep(planned, tmp_path / "apart", 1, page=False)
    fused_form(planned.base)
    monkeypatch.setattr(fused, "_LOOK", 0.0)
    found = sweep(planned, tmp_path / "fused", 1, page=False)
    tables = [
        pads.dataset(tmp_path / name / "runs").to_table().sort_by("run").drop_columns(list(OTHERS))
        for name in ("apart", "fused")
    ]

    assert (few.fused, few.apart) == (0, {fused.TOO_FEW: 40})
    assert found.fused >= 30
    assert found.fused + sum(found.apart.values()) == 40
    assert set(found.apart) <= {fused.NOT_YET, proven.FIRST}
    assert tables[0].equals(tables[1])


def test_a_form_with_other_bits_makes_no_run(plan):
    planned = plan({"spacecraft.m_s": {"values": [820.0, 300.0, 500.0]}})
    form = fused_form(planned.base)
    place = form.places["contact.k_m"]
    form.start[place] = np.nextafter(form.start[place], np.inf)  # as a compiler that rounds otherwise
    wrong = Stepper(planned, form)
    right = Stepper(planned)
    made = [wrong.row(run) for run in range(3)]

    assert [row.made for row in made] == [proven.NOT_EXACT] * 3
    assert [told(row) for row in made] == [told(right.row(run)) for run in range(3)]


def reason(planned):
    fusing = Fusing(planned)
    fusing.advance()
    fusing.close()
    return fusing.form


def test_what_is_known_without_sources_is_said_of_the_first_run_on(plan):
    assert Fusing(plan({"spacecraft.m_s": {"values": [300.0, 900.0]}})).form == fused.TOO_FEW
    order = {"coupling.order": {"values": [MEMBERS, [MEMBERS]]}}
    assert Fusing(plan(order)).form == "coupling.order changes the system itself"


def test_without_what_builds_native_fmus_runs_are_made_with_the_fmus_apart(plan, monkeypatch):
    monkeypatch.setattr(installation, "is_installed", lambda module: module != "casadi")
    planned = plan({"spacecraft.m_s": {"uniform": [500, 900]}}, design={"method": "random", "size": 256})

    assert reason(planned).startswith("the fused form of a system: not installed, got no casadi")


def test_the_failure_of_a_compiler_is_told_with_its_first_line(plan, monkeypatch):
    def fail(sources, name):
        raise NativeBuildError(
            f"native build of {name}: the compiler failed:\nruns.c:7: no such file\n  1 error"
        )

    monkeypatch.setattr(native, "begin_host", fail)
    monkeypatch.setattr("master.fuse.runs.Draft.is_compiled", False)
    many = {"design": {"method": "random", "size": 100_000}}
    told = reason(plan({"spacecraft.m_s": {"uniform": [300.0, 900.0]}}, **many))

    assert told == "native build of runs: the compiler failed: runs.c:7: no such file"


def test_a_varied_value_that_the_form_does_not_take_is_named_before_anything_is_compiled(plan, monkeypatch):
    draft = Draft(FusedForm(Path("none"), np.zeros(0), {}), {})
    monkeypatch.setattr(fused, "draft_of", lambda base: draft)
    many = {"design": {"method": "random", "size": 100_000}}
    told = reason(plan({"spacecraft.m_s": {"uniform": [300.0, 900.0]}}, **many))

    assert told == "start values that a connection replaces: spacecraft.m_s"


def test_what_keeps_a_campaign_from_the_fused_form_is_said(plan, monkeypatch):
    many = {"design": {"method": "random", "size": 100_000}}
    order = {"coupling.order": {"choice": [MEMBERS, [MEMBERS]]}}
    mass = {"spacecraft.m_s": {"uniform": [300.0, 900.0]}}

    assert reason(plan(order, **many)) == "coupling.order changes the system itself"
    assert reason(plan(mass, design={"method": "random", "size": 10})) == fused.TOO_FEW
    guarded = plan(mass, {"stop_when": "spacecraft.v_des > 0.1"}, **many)
    assert reason(guarded) == "stop_when ends runs"
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    monkeypatch.setattr("master.fuse.runs.Draft.is_compiled", False)
    assert reason(plan(mass, **many)).startswith("the fused form of a system: not installed, got no casadi")
