"""A step that the Python flavour refuses ends a run as one that the native flavour refuses: exit 3."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from fmu_sources.composed.registry import load, modules
from fmu_sources.export.python_flavour import build_python
from master.cli import main

SYSTEM = """\
name: refused
step_size: {step}
stop_time: 0.01
fmus:
  spacecraft: {{source: ./spacecraft.fmu, parameters: {{sample_time: {period}}}}}
coupling: {{order: [spacecraft]}}
"""


@pytest.mark.parametrize(
    ("step", "period", "message"),
    [
        (
            1e-3,
            1e-12,
            "too long for sample_time, got 0.001 s, expected at most 10000 sampling periods of 1e-12 s",
        ),
        (1e-3, 3e-4, "not a multiple of sample_time, got 0.001 s, expected a multiple of 0.0003 s"),
    ],
)
def test_a_refused_step_is_a_failure_and_says_why(step, period, message, tmp_path):
    (tmp_path / "spacecraft.fmu").write_bytes(build_python(load("spacecraft"), *modules("spacecraft")))
    config = tmp_path / "refused.yaml"
    config.write_text(SYSTEM.format(step=step, period=period))

    done = CliRunner().invoke(main, ["run", str(config), "--json", "--output", str(tmp_path / "results")])

    assert done.exit_code == 3
    assert json.loads(done.stdout)["status"] == "failed"
    assert "spacecraft at t=0 s: " in done.stderr
    assert f"communication step: {message}" in done.stderr
