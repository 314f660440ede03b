"""The picture of `dockloop check CASE --plot`: the model as it is, and none of the sealed rows."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.answer.nominal_picture import nominal_charts
from master.diagnosis.answer.replayed import Replayed


def test_sealed_rows_are_left_out_and_the_residual_is_measured_less_simulated():
    measured = np.array([[1.0], [2.0], [3.0], [4.0]])
    part = Replayed(
        part=SimpleNamespace(compared={"axis.force": "force"}),
        t=np.arange(4.0),
        measured=measured,
        predicted=0.5 * measured,
        sealed=np.array([1, 2]),
    )
    signal, residual = nominal_charts(part)

    assert [curve.label for curve in signal.curves] == ["measured", "the model as it is"]
    for curve in (*signal.curves, *residual.curves):
        assert np.isnan(curve.y).tolist() == [False, True, True, False]
    assert residual.curves[0].y[[0, 3]].tolist() == [0.5, 2.0]


def test_a_case_is_checked_and_drawn(tmp_path):
    plot = tmp_path / "nominal.png"
    done = CliRunner().invoke(main, ["check", "first_case", "--plot", str(plot)])

    assert done.exit_code == 0, done.output
    assert plot.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("config", "plot"), [("low_frequency", "x.png"), ("first_case", "x.svg")])
def test_a_system_and_another_ending_are_refused(config, plot):
    done = CliRunner().invoke(main, ["check", config, "--plot", plot])

    assert (done.exit_code, "--plot: " in done.output) == (2, True)
