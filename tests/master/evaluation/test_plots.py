import matplotlib.figure
import numpy as np
import pytest

from master.evaluation.plots import charts
from master.pages.picture import save as save_picture
from master.recording.recorder import Result
from master.system.config import Compare

NAMES = ("m.s", "m.r", "ideal.s", "m.f", "ideal.f")


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """Draw a run and give the axes."""
    figures = []
    save = matplotlib.figure.Figure.savefig
    monkeypatch.setattr(
        matplotlib.figure.Figure, "savefig", lambda self, *a, **k: (figures.append(self), save(self, *a, **k))
    )

    def draw(scale=0.01, **named):
        time = np.linspace(0.0, 1.0, 11)
        values = scale * np.column_stack([np.cos(time + i) for i in range(5)])
        result = Result(time, NAMES, ("m", "m", "m", "N", "N"), values)
        compare = Compare(signal="m.s", offset=0.01, **named)
        path = save_picture("test", charts(result, compare), tmp_path / "plot.png")
        assert path.read_bytes().startswith(b"\x89PNG")
        return figures[-1].axes, result

    return draw


ALL = {"reproduced": "m.r", "reference": "ideal.s", "force": "m.f", "reference_force": "ideal.f"}


def test_all_panels_have_their_units(drawn):
    axes, _ = drawn(**ALL)

    assert [a.get_ylabel() for a in axes] == ["displacement [mm]", "force [N]", "deviation [mm]"]
    assert axes[-1].get_xlabel() == "time [s]"


def test_a_run_without_force_and_reference_has_one_panel(drawn):
    axes, _ = drawn()

    assert [a.get_ylabel() for a in axes] == ["displacement [mm]"]


def test_every_curve_is_named_in_the_legend(drawn):
    axes, _ = drawn(**ALL)

    assert [[t.get_text() for t in a.get_legend().get_texts()] for a in axes] == [
        ["ideal.s", "m.s", "m.r"],
        ["ideal.f", "m.f"],
        ["m.s - reference", "m.r - reference"],
    ]


def test_the_curves_are_the_values_in_the_unit_of_the_axis(drawn):
    axes, result = drawn(**ALL)

    assert np.array_equal(axes[0].lines[1].get_ydata(), 1e3 * result["m.s"])
    assert np.array_equal(axes[1].lines[1].get_ydata(), result["m.f"])
    assert np.allclose(axes[2].lines[1].get_ydata(), 1e3 * (result["m.r"] - result["ideal.s"]), rtol=1e-15)


def test_a_motion_of_metres_stays_in_metres(drawn):
    axes, _ = drawn(scale=3.0)

    assert axes[0].get_ylabel() == "displacement [m]"
