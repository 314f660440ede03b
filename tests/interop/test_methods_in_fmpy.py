"""The FMU of each method gives in FMPy the outputs that it carries, and says what it computes."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from fmu_sources.composed.registry import model_files
from fmu_sources.export import build
from tests.interop.experiment_in_fmu import BOUND, in_fmpy, vectors

METHODS = [name for name, path in model_files().items() if path.parent.name == "compensators"]

pytestmark = pytest.mark.slow


def built(name: str, flavour: str) -> Path:
    wanted = build.target(name, flavour)
    return wanted.path if wanted.is_current() else build.build(wanted)


@pytest.mark.parametrize("flavour", ["native", "fmi3"])
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n == "robust" else pytest.mark.long) for n in METHODS]
)
def test_a_method_gives_the_outputs_that_its_fmu_carries(name: str, flavour: str) -> None:
    given = vectors(built(name, flavour))

    assert given.output_names == ["f_comp", "s_cmd"]
    assert given.largest_deviation(in_fmpy(given, given.fmu, given.parameters)) <= BOUND


@pytest.mark.parametrize("flavour", ["native", "fmi3"])
def test_the_fmu_of_robust_explains_its_formulas_and_names_their_source(flavour: str) -> None:
    with zipfile.ZipFile(built("robust", flavour)) as fmu:
        page = fmu.read("documentation/index.html").decode()

    assert "F + A = -(A - t_s A&#x27;) kappa_s - A&#x27; epsilon" in page
    assert "Ljung, System Identification (1999)" in page
    assert "latency_tolerance" in page
