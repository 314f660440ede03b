"""Whatever stands in the file, the answer is a system or a list of faults."""

import copy
import random

import pytest
import yaml

from master.diagnosis.case.case import read_case
from master.diagnosis.data.measured_signals import opened
from master.errors import ConfigError
from master.experiment.prepare import prepare

SYSTEM = {
    "name": "test",
    "step_size": 0.5,
    "stop_time": 4.0,
    "fmus": {
        "clock": {"source": "clock.fmu", "every": 2},
        "mass": {"source": "integrator.fmu", "parameters": {"size": 1.0, "choice": "first", "on": True}},
    },
    "coupling": {"order": ["clock", ["mass"]]},
    "connections": [{"from": "clock.t", "to": "mass.u", "delay": 1}],
    "variants": {"big": {"mass": {"size": 5}}},
    "compare": {"signal": "mass.x", "offset": 0.01},
    "limits": {"clock.t": 3.0},
}
ODD = [None, True, 0, -1, 3, 1e400, float("nan"), 1e-320, "", "a", "a.b", ".", "mass.x", [], [[]], {}, {1: 2}]
ODD += [[None], {"mass": None}, 10**30, "\u00e9", {"mass": {"size": "wide"}}, [["mass", 3]], {None: 1}]


def places(data, at=()):
    yield at
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*at, key))


def mutate(choose):
    """Replace one or two values of the system by odd ones, or rename a key."""
    data = copy.deepcopy(SYSTEM)
    for _ in range(choose.randint(1, 2)):
        *way, last = choose.choice([p for p in places(data) if p])
        inner = data
        for key in way:
            inner = inner[key]
        if isinstance(inner, dict) and choose.random() < 0.2:
            inner[choose.choice(["x", 1, None, 2.5, True])] = inner.pop(last)
        else:
            inner[last] = copy.deepcopy(choose.choice(ODD))  # the next round may change what is in it
    return data


def problems_of(path):
    try:
        prepare(path)
    except ConfigError as error:
        return error.problems or ["an error without a problem"]
    return []


@pytest.mark.parametrize("seed", range(10))
def test_an_odd_file_gives_a_system_or_faults_with_their_place(bay, seed):
    choose = random.Random(seed)
    for _ in range(40):
        path = bay.write(yaml.safe_dump(mutate(choose), sort_keys=False, allow_unicode=True))
        problems = problems_of(path)

        assert [p for p in problems if not p.startswith(f"{path}:")] == []
        assert len(set(problems)) == len(problems)


DATES = ["2001-99-99", "2001-01-01T99:00:00", "2024-01-05"]
NUMBERS = ["0b_", "9" * 400, "9" * 5000, "1:30", "010", "1_0", ".nan", "-.inf", "1e400", "1e-400"]
YAML = ["&a", "*a", "&z [*z]", "!!python/name:os.system x", "!!binary x", "!x", "<<: 3", "? [a]", "---"]
SIGNS = [*"[]{}#'|>@`%~\\\t\n\0", '"', ": ", "- ", "\x1b[0m", '"\\e[0m"', "\u2028", "\ufeff"]
WORDS = ["null", "", "true", "mass.u", "mass.", ".u", "clock.t > ", "a" * 300]
PIECES = DATES + NUMBERS + YAML + SIGNS + WORDS
WHOLE = (
    yaml.safe_dump(SYSTEM, sort_keys=False)
    + """\
events:
- {at: 1.0, for: 1.0, freeze: mass.u}
- {when: clock.t > 2, jitter: {mass.u: 2}, seed: 3}
- {at: 0.5, set: {mass.size: 2}, offset: {mass.u: 1.5}}
dpdc: {design: auto, fmu: mass, ranges: {m_s: [1, 2]}}
"""
)
CASE = """\
name: tiny
fmus: {craft: {source: spacecraft, parameters: {m_s: 820}}}
recordings: {one: {file: rec.csv, rows: [0, 10]}}
time: {column: t, unit: s}
signals: {f: {column: f, unit: N}, s: {column: s, unit: m, lowpass: 100}, v: {rate_of: s}}
inputs: {craft.f: f}
compared: {craft.s_des: s}
refit: {craft.m_s: {low: 50, high: 2000}}
split: {blocks: [fit, select, fit, sealed], guard: 0.01}
starts: {craft.s_des: [-1, 1]}
slots: {craft.f: all}
replay: {cut: 2, decimate: 1}
"""


def garbled(text, choose):
    """Replace or insert pieces at one to three places."""
    for _ in range(choose.randint(1, 3)):
        start = choose.randrange(len(text) + 1)
        end = min(len(text), start + choose.choice([0, 0, 1, 3, 10]))
        text = text[:start] + choose.choice(PIECES) + text[end:]
    return text


def lines_of(problems):
    return [p for p in problems if p.isprintable() and len(p) < 2500]


@pytest.mark.parametrize("seed", range(8))
def test_garbled_text_gives_a_system_or_faults_of_one_line(bay, seed):
    choose = random.Random(seed)
    for _ in range(50):
        problems = problems_of(bay.write(garbled(WHOLE, choose)))

        assert lines_of(problems) == problems


@pytest.mark.parametrize("seed", range(4))
def test_garbled_text_gives_a_case_or_faults_of_one_line(tmp_path, seed):
    choose = random.Random(seed)
    path = tmp_path / "case.yaml"
    for _ in range(50):
        path.write_text(garbled(CASE, choose), encoding="utf-8")
        with pytest.raises(ConfigError) as caught:  # the recording is missing at least
            opened(read_case(path))

        assert lines_of(caught.value.problems) == caught.value.problems
