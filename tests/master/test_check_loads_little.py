import subprocess
import sys

from tests.conftest import PROJECT

CODE = """
import sys
from master.cli import main
try:
    main(["check", "configs/low_frequency.yaml"])
finally:
    print(sorted({"numpy", "fmpy", "lxml", "rich", "numba", "casadi", "matplotlib"} & set(sys.modules)))
"""


def test_checking_a_system_of_current_fmus_loads_none_of_the_large_libraries():
    subprocess.run(
        [sys.executable, "-m", "master", "check", "configs/low_frequency.yaml"], check=True, cwd=PROJECT
    )
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, check=True, cwd=PROJECT
    )
    assert done.stdout.splitlines()[-1] == "[]"
