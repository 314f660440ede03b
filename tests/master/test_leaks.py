"""Thousands of systems in one process, with native FMUs, leak neither handles nor memory."""

import gc
import os
import sys
from pathlib import Path

import pytest
import yaml

from fmu_sources.export.build import build, target
from master.api import prepare_to_run
from master.stepping.simulate import simulate
from master.system.grid import Grid

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts what /proc shows"),
]

RUNS = int(os.environ.get("DOCKLOOP_LEAK_RUNS", "2000"))  # 10 000 and more on demand
WARM_UP = 500


@pytest.fixture
def experiment(tmp_path):
    """Two native FMUs in an iterated group: libraries, states, rings, rows."""
    pytest.importorskip("casadi", reason="builds FMUs")
    fmu = target("oscillator")
    path = fmu.path if fmu.is_current() else build(fmu)
    given = {
        "name": "pair",
        "step_size": 1e-3,
        "stop_time": 1.0,
        "fmus": {name: {"source": str(path)} for name in ("a", "b")},
        "connections": [{"from": "a.y", "to": "b.u"}, {"from": "b.y", "to": "a.u", "delay": 2}],
        "coupling": {"order": [{"iterate": ["a", "b"]}]},
    }
    file = tmp_path / "pair.yaml"
    file.write_text(yaml.safe_dump(given))
    return prepare_to_run(file)


def handles():
    return len(os.listdir("/proc/self/fd"))


def mapped():
    return len(Path("/proc/self/maps").read_text().splitlines())


def resident():
    """Memory that the process has allocated: pages of files come and go as others need room."""
    lines = Path("/proc/self/status").read_text().splitlines()
    kilobytes = dict(line.split()[:2] for line in lines if line.startswith("Rss"))
    return 1024 * (int(kilobytes["RssAnon:"]) + int(kilobytes["RssShmem:"]))


def run(experiment, n):
    for _ in range(n):
        outcome = simulate(experiment.system, experiment.schedule, Grid(0.0, 1e-3, 3))
        assert outcome.status == "completed"


@pytest.fixture
def small_heap():
    """
    Let the collector see nothing of earlier tests.

    In a large heap it looks for cycles so rarely that those of thousands of runs would wait for it together.
    """
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.mark.usefixtures("small_heap")
def test_thousands_of_systems_leave_nothing_behind(experiment):
    run(experiment, WARM_UP)
    gc.collect()  # what earlier tests left is theirs
    before = handles(), mapped(), resident()
    run(experiment, RUNS)
    gc.collect()

    assert handles() == before[0]
    assert mapped() < before[1] + 200  # a library that stays loaded has five mappings a run
    # two instances of 1.5 kB that stay in each run would be 3 kB a run; the allocators drift by 2 MB at most
    assert resident() < before[2] + 2 * 2**20 + RUNS * 1000
