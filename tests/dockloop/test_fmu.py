"""Single FMUs: inspected, stepped by hand, made from models."""

from __future__ import annotations

import pytest

import dockloop as dl
from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import declare, input_, output, parameter


class Spring(Model):
    """Hooke's law."""

    name = "spring"
    description = "Linear spring"
    variables = declare(
        parameter("k", 100.0, "N/m", "Stiffness", above=0.0),
        input_("x", "m", "Extension"),
        output("f", "N", "Force"),
    )

    def outputs(self, t, x, u, p, m, slot=None):
        return {"f": p.k * u.x}


class Wrong(Spring):
    def outputs(self, t, x, u, p, m, slot=None):
        return {"g": p.k * u.x}


def test_an_fmu_says_what_it_is_without_running():
    fmu = dl.open_fmu("compensator")

    assert (fmu.name, fmu.capabilities["fmi_version"]) == ("compensator", "2.0")
    assert fmu.units("input") == {
        **{"s_des": "m", "s_act": "m", "f_mea": "N", "x": "m"},
        **{"v_des": "m/s", "a_des": "m/s2"},
    }
    assert fmu.odd == ()


def test_an_fmu_is_stepped_alone():
    with dl.open_fmu("spacecraft").open({"m_s": 2.0}) as sim:
        sim.set("fmu.f", 4.0)
        sim.step(10)

        assert sim["fmu.v_des"] == pytest.approx(0.02, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("flavour", ["native", "fmi3"])
def test_a_model_of_a_program_becomes_an_fmu(tmp_path, flavour):
    pytest.importorskip("casadi")
    path = dl.to_fmu(Spring(), tmp_path / "spring.fmu", flavour=flavour)
    with dl.open_fmu(path).open({"x": 0.5}) as sim:
        sim.step()

        assert sim["fmu.f"] == 50.0


def test_a_model_that_does_not_return_what_it_declares_is_refused(tmp_path):
    pytest.importorskip("casadi")
    with pytest.raises(dl.ConfigError) as error:
        dl.to_fmu(Wrong(), tmp_path / "x.fmu")

    assert error.value.problems == [
        "spring: output 'f' is declared, and outputs() does not return it",
        "spring: outputs() returns 'g', expected a declared output",
    ]
    assert not (tmp_path / "x.fmu").exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("MODEL = 3\n", "MODEL: not a model, got int, expected an instance of Model"),
        ("x = 1\n\n1/0\n", r"own\.py:3: ZeroDivisionError"),
        ("def f(:\n", r"own\.py:1: "),
        ("import no_such_module\n", r"own\.py:1: ModuleNotFoundError"),
    ],
)
def test_a_mistake_in_a_file_of_ones_own_is_said_with_its_line(tmp_path, text, message):
    pytest.importorskip("casadi")
    (tmp_path / "own.py").write_text(text, encoding="utf-8")

    with pytest.raises(dl.ConfigError, match=message):
        dl.to_fmu(tmp_path / "own.py", tmp_path / "own.fmu")


@pytest.mark.parametrize("other", [dl.block(["u"], ["y"], lambda t, h, v: {"y": v["u"]}), None, 5, {}])
def test_what_is_no_model_is_refused_with_what_would_be_one(tmp_path, other):
    with pytest.raises(dl.ConfigError) as caught:
        dl.to_fmu(other, tmp_path / "x.fmu")

    [problem] = caught.value.problems
    assert (problem.where, problem.what, problem.got) == ("to_fmu", "not a model", repr(other))
    assert "a model of equations" in problem.expected
    assert not (tmp_path / "x.fmu").exists()
