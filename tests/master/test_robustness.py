"""Whatever stands in the file, the answer is a system or a list of faults."""

import copy
import random

import pytest
import yaml

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
            inner[last] = choose.choice(ODD)
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
