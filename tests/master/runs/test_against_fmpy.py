"""`compare` against the file that FMPy writes of the same FMU."""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest
from click.testing import CliRunner

from master.cli import main

FMU = Path(__file__).parents[3] / "fmus" / "spacecraft.fmu"
TEXT = f"""\
name: falling
step_size: 0.01
stop_time: 1.0
fmus:
  mass: {{source: {FMU}, parameters: {{m_s: 2.0, sample_time: 0.01}}, start: {{v_des: 1.0, f: 3.0}}}}
"""


def call(*words):
    return CliRunner().invoke(main, [*map(str, words)])


@pytest.mark.parametrize(("mass", "code"), [(2.0, 0), (2.001, 1)])
def test_fmpys_file_is_equal_within_the_tolerance_and_not_where_a_signal_is_off(tmp_path, mass, code):
    config = tmp_path / "system.yaml"
    config.write_text(TEXT, encoding="utf-8")
    assert call("run", config, "--output", tmp_path / "out").exit_code == 0
    theirs = fmpy.simulate_fmu(
        str(FMU),
        stop_time=1.0,
        output_interval=0.01,
        start_values={"m_s": mass, "sample_time": 0.01, "v_des": 1.0, "f": 3.0},
    )
    fmpy.write_csv(str(tmp_path / "fmpy.csv"), theirs)
    done = call("compare", tmp_path / "out", tmp_path / "fmpy.csv", "--tolerance", "1e-12")

    assert done.exit_code == code, done.output
    assert "s_des of" in done.stdout
