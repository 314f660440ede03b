import subprocess
import sys

import pytest

from tests.conftest import PROJECT

CODE = """
import sys
from master.cli import main
try:
    main(["check", sys.argv[1]])
finally:
    print(sorted(set(sys.argv[2:]) & set(sys.modules)))
"""

OF_A_SYSTEM = ["numpy", "fmpy", "lxml", "rich", "numba", "casadi", "matplotlib"]
OF_A_CASE = [
    *("scipy.signal", "scipy.stats", "scipy.optimize", "scipy.interpolate", "scipy.linalg"),
    *("fmpy", "lxml", "rich", "numba", "casadi", "matplotlib"),
]


@pytest.mark.parametrize(
    ("config", "large"),
    [("configs/low_frequency.yaml", OF_A_SYSTEM), ("configs/measured/first_case.yaml", OF_A_CASE)],
)
def test_checking_with_current_fmus_loads_none_of_the_large_libraries(config, large):
    subprocess.run([sys.executable, "-m", "master", "check", config], check=True, cwd=PROJECT)
    done = subprocess.run(
        [sys.executable, "-c", CODE, config, *large], capture_output=True, text=True, check=True, cwd=PROJECT
    )
    assert done.stdout.splitlines()[-1] == "[]"
