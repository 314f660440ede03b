"""What all tests share: whole systems are slow, and what is slow in Python is not measured for coverage."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.forked_coverage import count_forked_processes
from tests.systems.browser import Browser, opened

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy, as the command has it

PROJECT = Path(__file__).parents[1]
SLOW = PROJECT / "tests" / "systems"
NOT_MEASURED = [  # Python models and runs alike, whose lines others cover
    PROJECT / "tests" / name
    for name in (
        "fmu_sources/export/native",
        "fmu_sources/motion_simulator",
        "fmu_sources/rigs",
        "foreign/test_sandboxed_fmus.py",
        "fuzz",
        "interop",
        "master/cli/test_signals.py",
        "master/runs/test_resume.py",
        "oracles",
        "reliability",
        "rig",
        "systems/test_analysis.py",
        "systems/test_paper_cases.py",
    )
]
LONGEST_FIRST = [  # a file runs in one process, so a long one must not begin when the others are done
    PROJECT / "tests" / name
    for name in (
        "master/test_leaks.py",  # first of all in its process, whose memory nothing else has used then
        "systems/test_diagnosis_of_measured_data.py",
        "systems/test_diagnosis_of_the_virtual_rig.py",
        "systems/test_first_case.py",
        "systems/test_analysis.py",
        "interop/test_importers.py",
        "installed",
        "systems",
        "fmu_sources/motion_simulator",
        "fmu_sources/export/native",
        "master/stepping",
        "master/cli",
    )
]


def pytest_configure(config: pytest.Config) -> None:
    config.option.loadscopereorder = False  # pytest-xdist: by the number of tests, which says little
    if config.pluginmanager.has_plugin("_cov"):
        count_forked_processes()


def _rank(item: pytest.Item) -> int:
    ranks = (i for i, place in enumerate(LONGEST_FIRST) if item.path.is_relative_to(place))
    return next(ranks, len(LONGEST_FIRST))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=_rank)
    for item in items:
        if SLOW in item.path.parents:
            item.add_marker(pytest.mark.slow)
        if any(item.path.is_relative_to(place) for place in NOT_MEASURED):
            item.add_marker(pytest.mark.no_cover)


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One browser for all tests of a process."""
    with opened(tmp_path_factory.mktemp("profile")) as found:
        yield found


@pytest.fixture(scope="session")
def data() -> Path:
    """Folder of the measured data; its absence fails where it is required, skips elsewhere."""
    folder = Path(os.environ.get("DOCKLOOP_DATA", PROJECT.parent / "shared" / "data"))
    if not folder.is_dir():
        message = f"DOCKLOOP_DATA: no such folder, got {folder}, expected the measured data"
        if os.environ.get("DOCKLOOP_REQUIRE_DATA") or os.environ.get("CI"):
            pytest.fail(message)
        pytest.skip(message)
    os.environ["DOCKLOOP_DATA"] = str(folder)  # the cases of `configs/measured` name it
    return folder
