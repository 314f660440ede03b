"""A foreign FMU that a case names gets effects at its ports, without an edit of the case."""

import shutil

import numpy as np
import pytest

from master import catalogue
from master.diagnosis.answer.answer import answer
from master.diagnosis.answer.replayed import replay
from master.diagnosis.case.case import load_case
from master.diagnosis.case.cut import cut
from master.errors import ConfigError
from tests.foreign.build import describe_2
from tests.foreign.foreign import COMPILED

pytestmark = COMPILED

BLOCKS = (
    "[fit, select, fit, sealed, fit, select, fit, select, fit, sealed, fit, select, fit, select, fit, sealed]"
)
UNITS = """<UnitDefinitions>
  <Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>
  <Unit name="kN"><BaseUnit kg="1" m="1" s="-2" factor="1000"/></Unit>
</UnitDefinitions>
"""
PASSING = f"""name: passing
fmus: {{s: {{source: ./types2.fmu}}}}
recordings: {{run: run.csv}}
time: {{column: t}}
signals: {{u: {{column: u, unit: m}}, y: {{column: y, unit: N}}}}
inputs: {{s.Real_in: u}}
set: {{s.Integer_in: 0, s.Enumeration_in: low, s.Boolean_in: false}}
compared: {{s.Real_out: y}}
split: {{blocks: {BLOCKS}, guard: 0.0}}
"""
AXIS = f"""name: axis
fmus: {{box: {{source: ./box.fmu, parameters: {{mass: 95.1, damping: 203.5}}}}}}
recordings: {{run: run.csv}}
time: {{column: t, unit: s}}
signals:
  q: {{column: q, unit: mm}}
  v: {{column: v, unit: m/s}}
  a: {{column: a, unit: m/s2}}
  f: {{column: f, unit: kN}}
inputs: {{box.q: q, box.der_q: v, box.der_der_q: a}}
compared: {{box.force: f}}
slots: {{box.force: [coulomb, quadratic_damping, gain_error, offset, extra_lag]}}
split: {{blocks: {BLOCKS}, guard: 0.1}}
"""
FRICTION = 20.0  # N
NOISE = 0.5  # N


def in_units(text):
    """The FMU whose real output is its real input, the number as it is: mm in, kN out."""
    text = text.replace("<TypeDefinitions>", UNITS + "<TypeDefinitions>")
    text = text.replace('<Real start="0"/>', '<Real unit="mm" start="0"/>', 1)
    return text.replace("<Real/>", '<Real unit="kN"/>', 1)


def passing(folder, gain, noise):
    """By hand: u m are 1000 u mm, and as many kN are 1e6 u N."""
    rng = np.random.default_rng(7)
    t = 0.01 * np.arange(2000)
    u = 1e-3 * (np.sin(1.7 * t) + np.sin(5.3 * t))
    y = gain * 1e6 * u + noise * rng.standard_normal(len(t))
    table = np.column_stack([t, u, y])
    np.savetxt(folder / "run.csv", table, delimiter=",", header="t,u,y", comments="", fmt="%.12g")
    (folder / "case.yaml").write_text(PASSING, encoding="utf-8")
    return folder / "case.yaml"


def test_ports_are_driven_and_compared_in_the_units_of_the_fmu(fmu, tmp_path):
    fmu("2.0", in_units(describe_2()))
    (found,) = replay(passing(tmp_path, 1.0, 0.0)).values()

    assert found.predicted == pytest.approx(found.measured, abs=1e-6)
    assert np.ptp(found.measured) > 2000.0


def test_a_gain_of_a_foreign_fmu_is_found_at_its_ports(fmu, tmp_path):
    fmu("2.0", in_units(describe_2()))
    report = answer(passing(tmp_path, 1.06, 3.0), tmp_path / "out", lambda _: None)

    assert report["verdict"] == "one of a class"  # a gain before it or after it, nothing recorded tells
    (found,) = report["effects"]
    assert (found["fmu"], found["effect"]) == ("s", "gain_error")
    assert found["slot"] in ("Real_in", "Real_out")
    assert found["parameters"]["error"] == pytest.approx(0.06, abs=3e-4)
    assert report["after"]["s.Real_out"]["rmse"] == pytest.approx(3.0, rel=0.05)
    corrected = tmp_path / "out" / "passing_corrected.yaml"
    (replayed,) = replay(tmp_path / "case.yaml", corrected).values()
    errors = replayed.errors()["s_Real_out.y"]
    assert errors["rmse"] == pytest.approx(report["after"]["s.Real_out"]["rmse"], rel=1e-9)


@pytest.fixture
def axis(tmp_path):
    """An inverse axis as a file of another tool, and what friction leaves of it."""
    target = {"box": catalogue.locate("servo_axis_inverse", tmp_path, "native")}
    shutil.copy(catalogue.files(target, catalogue.silent)["box"], tmp_path / "box.fmu")
    rng = np.random.default_rng(3)
    t = 1e-3 * np.arange(6000)
    parts = [(0.05, 0.9, 0.0), (0.02, 2.3, 0.4), (0.01, 0.31, 1.0)]
    angles = [(size, 2.0 * np.pi * f, 2.0 * np.pi * f * t + phase) for size, f, phase in parts]
    q = sum(size * np.sin(x) for size, _, x in angles)
    v = sum(size * w * np.cos(x) for size, w, x in angles)
    a = sum(-size * w**2 * np.sin(x) for size, w, x in angles)
    force = 95.1 * a + 203.5 * v + FRICTION * np.tanh(v / 2e-3) + NOISE * rng.standard_normal(len(t))
    table = np.column_stack([t, 1e3 * q, v, a, 1e-3 * force])
    np.savetxt(tmp_path / "run.csv", table, delimiter=",", header="t,q,v,a,f", comments="", fmt="%.12g")
    (tmp_path / "case.yaml").write_text(AXIS, encoding="utf-8")
    return tmp_path / "case.yaml"


def test_friction_at_the_force_of_a_foreign_fmu_is_found_and_named(axis):
    folder = axis.parent / "out"
    report = answer(axis, folder, lambda _: None)

    assert report["verdict"] == "traced"
    (found,) = report["effects"]
    assert (found["fmu"], found["slot"], found["effect"]) == ("box", "force", "coulomb")
    assert found["parameters"]["level"] == pytest.approx(FRICTION, abs=0.1)
    assert report["after"]["box.force"]["rmse"] < 1.05 * NOISE
    assert report["subsystem"] == "box"
    assert "box_force" not in report["sentence"]
    page = (folder / "report.html").read_text(encoding="utf-8")
    told = page[page.index("The model lacks Coulomb friction (level 20") :][:200]
    assert " N, smoothing " in told
    assert " in box.force." in told


def test_a_case_may_choose_the_effects_at_a_port(axis):
    system = cut(load_case(axis))
    slots = system.loaded.case.slots

    assert slots["box_force.answer"] == ["extra_lag", "gain_error", "offset"]
    assert slots["box_force.resistance"] == ["coulomb", "quadratic_damping"]
    assert slots["box_q.answer"] == slots["box_der_q.answer"] == []
    assert [part.name for part in system.parts] == ["box"]


def test_an_effect_that_no_port_can_take_is_refused(axis):
    text = AXIS.replace("slots: {box.force:", "slots: {box.q: [coulomb], box.mass: all, box.force:")
    axis.write_text(text, encoding="utf-8")

    with pytest.raises(ConfigError) as caught:
        cut(load_case(axis))
    message = str(caught.value)
    assert "slots.box.q: the slot has no signals for it, got 'coulomb'" in message
    assert "slots.box.mass: no slot at this port of a file, got 'mass'" in message
