"""Random valid systems step as a bare loop over FMPy steps them."""

import sys

import pytest

from tests.costs import long_for
from tests.fuzz.compared import compile_mixer, difference

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="compiles for Linux on x86_64"),
]

N_QUICK, N_SYSTEMS = 60, 300


@pytest.fixture(scope="module")
def binaries(tmp_path_factory):
    return compile_mixer(tmp_path_factory.mktemp("mixer"))


@pytest.mark.parametrize("seed", long_for(range(N_QUICK + 1, N_SYSTEMS + 1), range(1, N_SYSTEMS + 1)))
def test_a_random_system_steps_as_a_bare_loop_steps_it(seed, binaries, tmp_path):
    assert difference(seed, binaries, tmp_path) == ""
