"""However a diagnosis ends, no FMU stays loaded and no folder stays in the temporary directory."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
import yaml

from master.diagnosis.answer import answer as answering
from master.diagnosis.answer import before_after
from master.diagnosis.answer.answer import answer
from master.diagnosis.case.case import load_case
from master.diagnosis.case.cut import cut
from master.diagnosis.judge import diagnose as diagnosing
from master.diagnosis.judge import named_or_learned
from master.diagnosis.judge.diagnose import diagnose
from master.diagnosis.replay.candidate_models import links
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.replay.replayer import Player
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.rounds import SearchResult
from master.errors import ConfigError, FmuError
from master.fmi.loaded_fmu import FmuSlave

pytest.importorskip("casadi", reason="builds FMUs")

CASE = {
    "name": "two",
    "fmus": {
        name: {"source": "servo_axis_inverse", "parameters": {"mass": 90, "damping": 200}}
        for name in ("axis", "other")
    },
    "recordings": {"run": "run.npz"},
    "time": {"column": "t"},
    "signals": {
        "q": {"column": "q", "unit": "m"},
        "v": {"rate_of": "q"},
        "a": {"rate_of": "v"},
        "f": {"column": "f", "unit": "N"},
    },
    "inputs": {
        f"{fmu}.{variable}": signal
        for fmu in ("axis", "other")
        for variable, signal in (("q", "q"), ("der_q", "v"), ("der_der_q", "a"))
    },
    "compared": {"axis.force": "f", "other.force": "f"},
    "refit": {"axis.mass": {"low": 10, "high": 200}, "other.mass": {"low": 10, "high": 200}},
    "slots": {"axis.friction": ["coulomb"], "other.friction": ["coulomb"]},
    "split": {"blocks": ["fit", "select", "fit", "sealed"], "guard": 0.05},
}


def recorded(folder, coulomb):
    """A motion of a mass with viscous friction, and Coulomb friction of a size [N]; the case with it."""
    t = np.arange(2000) * 1e-3
    q = 0.1 * np.sin(3.0 * t)
    v = np.gradient(q, t)
    a = np.gradient(v, t)
    np.savez(folder / "run.npz", t=t, q=q, f=90.0 * a + 200.0 * v + coulomb * np.tanh(v / 0.01))
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(CASE))
    return path


@pytest.fixture
def exact(tmp_path):
    """A case that is replayed to rounding: nothing is searched for."""
    return recorded(tmp_path, coulomb=0.0)


@pytest.fixture
def lacking(tmp_path, monkeypatch):
    """A case whose model lacks an effect; tests and search end at once."""
    monkeypatch.setattr(diagnosing, "detect", lambda result: result)
    monkeypatch.setattr(diagnosing, "search", lambda study, base, effects, **_: nothing_found(base))
    return recorded(tmp_path, coulomb=20.0)


def nothing_found(base):
    return SearchResult(base, ExtendedModel(), base, ())


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def assert_clean(temporary):
    assert list(temporary.iterdir()) == []
    if sys.platform.startswith("linux"):
        assert str(temporary) not in Path("/proc/self/maps").read_text()


def raising(error):
    def function(*args, **kwargs):
        raise error

    return function


INJECTED = [FmuError("other", "injected"), KeyboardInterrupt()]
STAGES = {
    "the refit of the base": (diagnosing, "begin"),
    "the check of the signals": (diagnosing, "implausible"),
    "a replay": (ReplayBench, "predict"),
    "the corrected FMUs": (answering, "correct"),
    "the sealed part": (before_after, "_run"),
    "the panels": (answering, "panels"),
    "the report": (answering, "as_dict"),
}
STAGES_OF_SEARCH = {
    "the tests on the residual": (diagnosing, "detect"),
    "the search": (diagnosing, "search"),
    "a law without a name": (named_or_learned, "learn"),
    "the last fit": (diagnosing, "_parameters"),
}


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("error", INJECTED, ids=["error", "ctrl-c"])
def test_nothing_stays_loaded_when_a_stage_fails(exact, temporary, monkeypatch, tmp_path, stage, error):
    if stage != "the panels":
        monkeypatch.setattr(answering, "panels", lambda *args: [])
    monkeypatch.setattr(*STAGES[stage], raising(error))

    with pytest.raises(type(error)):
        answer(exact, tmp_path / "results", lambda text: None)
    assert_clean(temporary)


@pytest.mark.parametrize("stage", STAGES_OF_SEARCH)
@pytest.mark.parametrize("error", INJECTED, ids=["error", "ctrl-c"])
def test_nothing_stays_loaded_when_the_search_fails(lacking, temporary, monkeypatch, stage, error):
    if stage == "the last fit":
        monkeypatch.setattr(named_or_learned, "learn", lambda *args, **kwargs: None)
    monkeypatch.setattr(*STAGES_OF_SEARCH[stage], raising(error))

    with pytest.raises(type(error)):
        diagnose(load_case(lacking), lambda text: None)
    assert_clean(temporary)


def test_nothing_stays_loaded_when_a_signal_is_implausible(exact, temporary, monkeypatch):
    monkeypatch.setattr(diagnosing, "implausible", lambda loaded, parts: ["injected"])

    with pytest.raises(ConfigError, match="injected"):
        diagnose(load_case(exact), lambda text: None)
    assert_clean(temporary)


@pytest.mark.parametrize("error", INJECTED, ids=["error", "ctrl-c"])
def test_nothing_stays_loaded_when_the_second_of_two_fmus_cannot_be_loaded(exact, temporary, error):
    """The chain is taken apart by whoever made it, also where it was not whole."""
    system = cut(load_case(exact))
    chain = [
        link
        for part in system.parts
        for link in links(system, part, {fmu: system.descriptions[fmu].path for fmu in part.fmus})
    ]
    with pytest.MonkeyPatch.context() as patch:
        load = FmuSlave.__init__

        def init(self, name, description):
            if name == "other":
                raise error
            load(self, name, description)

        patch.setattr(FmuSlave, "__init__", init)
        with pytest.raises(type(error)):
            Player(chain)
    assert_clean(temporary)


def test_a_diagnosis_unloads_its_fmus_when_it_is_closed(exact, temporary):
    with diagnose(load_case(exact), lambda text: None) as diagnosis:
        assert [part.is_exact for part in diagnosis.parts] == [True, True]
        assert len(list(temporary.iterdir())) == 1  # one file, one folder for both instances
    assert_clean(temporary)


def test_nothing_stays_loaded_when_ctrl_c_arrives_between_two_parts(exact, temporary):
    texts = []

    def interrupt(text):
        texts.append(text)
        if text.startswith("other"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        diagnose(load_case(exact), interrupt)
    assert any(text.startswith("axis") for text in texts)
    assert_clean(temporary)
