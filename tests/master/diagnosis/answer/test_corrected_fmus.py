"""The corrected system: sources with effects, parameters that were fitted, paths from its new folder."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from master.diagnosis.answer import corrected_fmus
from master.diagnosis.answer.corrected_fmus import confirmed, correct, corrected_values
from master.diagnosis.case.cut import CutPart, MeasuredInput
from master.diagnosis.data.recordings import Recording
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.system.config import Config

FRICTION = PlacedEffect("axis", "friction", "coulomb")
CONFIG = {
    "name": "rig",
    "step_size": 0.001,
    "stop_time": 1.0,
    "fmus": {
        "axis": {"source": "servo_axis_inverse", "parameters": {"mass": 90.0, "damping": 200.0}},
        "box": {"source": "foreign/box.fmu"},
    },
    "variants": {"heavy": {"axis": {"mass": 120.0}}},
}


def part(effects, values, *, pays=True):
    return SimpleNamespace(
        chosen=ExtendedModel(tuple(effects)),
        has_effect=bool(effects),
        parameter_gain=pays,
        values=values,
    )


def diagnosis(parts, folder, variant=None):
    system = SimpleNamespace(
        config=Config.model_validate(CONFIG),
        folder=folder,
        sources={"axis": "servo_axis_inverse", "box": "foreign/box.fmu"},
        parts=(),
    )
    case = SimpleNamespace(name="rig_2", variant=variant)
    return SimpleNamespace(system=system, parts=parts, loaded=SimpleNamespace(case=case))


@pytest.fixture
def built(monkeypatch):
    """Builds of FMUs are files that hold what they were asked for."""

    def build(name, starts, flavour, path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{name} {flavour} {dict(starts)}")
        return path

    monkeypatch.setattr(corrected_fmus, "build_with_starts", build)


def test_the_new_model_is_written_in_both_flavours_and_named_in_the_system(built, tmp_path):
    values = {"axis.mass": 95.5, "axis.friction_coulomb_level": 20.0}
    out = tmp_path / "results" / "answer"

    corrected = correct(diagnosis([part([FRICTION], values)], tmp_path), out)

    name = "servo_axis_inverse__friction_coulomb"
    assert [f.relative_to(out).as_posix() for f in corrected.files] == [
        f"native/{name}.fmu",
        f"python/{name}.fmu",
        "axis.ssv",
        "rig_2_corrected.yaml",
    ]
    assert corrected.native == {"axis": out / "native" / f"{name}.fmu"}
    starts = {"mass": 95.5, "friction_coulomb_level": 20.0}
    assert corrected.native["axis"].read_text() == f"{name} native {starts}"
    assert 'name="friction_coulomb_level"' in (out / "axis.ssv").read_text()
    assert 'Real value="95.5"' in (out / "axis.ssv").read_text()
    document = yaml.safe_load(corrected.system.read_text())
    assert document["name"] == "rig_2_corrected"
    assert document["fmus"]["axis"] == {
        "source": f"./native/{name}.fmu",
        "parameters": {"mass": 95.5, "damping": 200.0, "friction_coulomb_level": 20.0},
    }


def test_a_foreign_file_is_found_from_the_new_folder(built, tmp_path):
    out = tmp_path / "results" / "answer"

    correct(diagnosis([part([FRICTION], {})], tmp_path), out)

    source = yaml.safe_load((out / "rig_2_corrected.yaml").read_text())["fmus"]["box"]["source"]
    assert (out / source).resolve() == (tmp_path / "foreign" / "box.fmu").resolve()
    assert not Path(source).is_absolute()


def test_a_fit_goes_over_the_variant_and_that_over_the_file(built, tmp_path):
    correct(diagnosis([part([FRICTION], {"axis.damping": 180.0})], tmp_path, "heavy"), tmp_path / "out")

    document = yaml.safe_load((tmp_path / "out" / "rig_2_corrected.yaml").read_text())
    assert document["fmus"]["axis"]["parameters"] == {"mass": 120.0, "damping": 180.0}


def test_parameters_that_do_not_pay_stay_as_they_are(built, tmp_path):
    parts = [part([], {"axis.mass": 91.0}, pays=False), part([], {"box.gain": 2.0})]

    assert corrected_values(diagnosis(parts, tmp_path)) == {"box": {"gain": 2.0}}
    assert correct(diagnosis(parts, tmp_path), tmp_path / "out").native == {}


@pytest.mark.parametrize("effects", [[FRICTION], []])
def test_what_the_sealed_rows_do_not_confirm_is_not_exported(built, tmp_path, effects):
    """Files, folders and the corrected system are gone; other files of the folder stay."""
    own = part(effects, {"axis.mass": 95.5})
    own.name = "axis"
    given = diagnosis([own], tmp_path)
    out = tmp_path / "out"
    corrected = correct(given, out)
    (out / "report.json").write_text("{}")

    left = confirmed(
        given, corrected, {"axis": SimpleNamespace(is_confirmed=False, is_refit_worse=True)}, out
    )

    assert left.files == ()
    assert left.native == {}
    assert [f.name for f in out.rglob("*")] == ["report.json"]


def test_inputs_that_nothing_drives_are_driven_by_the_recording(built, tmp_path):
    """A run takes the value at the end of a step: one that a replay takes at its start is a row later."""
    given = diagnosis([part([FRICTION], {})], tmp_path)
    given.system.parts = (
        CutPart(
            ("axis",),
            {"axis": {"q": MeasuredInput("q", "end"), "der_q": MeasuredInput("v", "start")}},
            {"axis": {}},
            {},
        ),
    )
    t = np.arange(5) * 1e-3
    given.recordings = {"run": Recording("run", t, {"q": t + 1.0, "v": t + 2.0}, 1e-3)}

    corrected = correct(given, tmp_path / "out")

    document = yaml.safe_load(corrected.system.read_text())
    assert (document["step_size"], document["stop_time"]) == (1e-3, 4e-3)
    [entry] = document["inputs"]
    assert entry["map"] == {"axis.q": {"column": "axis.q"}, "axis.der_q": {"column": "axis.der_q"}}
    table = pq.read_table(tmp_path / "out" / entry["file"]).to_pydict()
    assert table["axis.q"] == (t + 1.0).tolist()
    assert table["axis.der_q"] == pytest.approx([2.0, 2.0, 2.001, 2.002, 2.003])
