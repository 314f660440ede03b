"""The FMUs and systems of others: each gives what its authors published, or is rightly refused."""

import shutil

import pytest

from tests.conformance.cases import all_cases
from tests.conformance.material import FOLDER, build_reference_fmus

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FOLDER.is_dir(), reason=f"DOCKLOOP_FOREIGN: no such folder, got {FOLDER}"),
]

CASES = all_cases() if FOLDER.is_dir() else []


@pytest.fixture(scope="module")
def reference_fmus(tmp_path_factory):
    assert shutil.which("cmake"), "cmake: not found, expected it to build the Reference FMUs"
    return build_reference_fmus(tmp_path_factory.mktemp("reference"))


@pytest.mark.parametrize("case", CASES, ids=[case.title for case in CASES])
def test_it_gives_what_its_authors_published(case, reference_fmus, tmp_path):
    finding = case.judge(reference_fmus, tmp_path)

    assert finding.is_right, f"{finding.status}: {finding.remark}"
