"""Curves on their way to the page: thinned out, encoded, each with a look of its own."""

from __future__ import annotations

import base64
import itertools
import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from master.pages.chart import CROSS, DOTTED, REFERENCE, Chart, Curve, Region, decimated
from master.pages.encoding import encoded, page_data
from master.pages.palette import DASHES, DOTS
from master.pages.picture import data_uri, save
from tests.master.pages.made_up_charts import charts, motions


def test_thinning_keeps_ends_extremes_and_gaps():
    x = np.linspace(0.0, 10.0, 10001)
    y = np.sin(x)
    y[5000] = 7.0
    y[7000:7003] = np.nan
    thin = decimated(Curve("y", x, y), columns=50)

    assert len(thin.x) <= 103
    assert (thin.x[0], thin.x[-1]) == (0.0, 10.0)
    assert (np.nanmax(thin.y), np.nanmin(thin.y)) == (7.0, np.nanmin(y))
    assert all(np.diff(thin.x) > 0.0)
    assert thin.x[np.isnan(thin.y)].tolist() == [x[7000]]


def test_marks_are_never_thinned():
    marks = Curve("poles", np.arange(5000.0), np.zeros(5000), CROSS)

    assert decimated(marks, columns=10) is marks


def test_the_reference_is_grey_and_takes_no_colour():
    t = np.zeros(2)
    chart = Chart("", "", "", [Curve("ideal", t, t, REFERENCE), Curve("a", t, t), Curve("b", t, t)])

    assert chart.looks == [None, (0, ()), (1, DASHES[1])]


def test_a_theory_is_dotted_in_the_colour_of_what_it_is_the_theory_of():
    t = np.zeros(2)
    theory = [Curve(f"{n}, theory", t, t, DOTTED, like=n) for n in "ab"]
    chart = Chart("", "", "", [Curve("a", t, t), Curve("b", t, t), *theory])

    assert [look.colour for look in chart.looks] == [0, 1, 0, 1]
    assert [look.dashes for look in chart.looks[2:]] == [DOTS, DOTS]


def decoded(array):
    """What the page's script makes of an array."""
    if "n" in array:
        return array["first"] + array["step"] * np.arange(array["n"])
    if "f8" in array:
        return np.frombuffer(base64.b64decode(array["f8"]), "<f8")
    return np.frombuffer(base64.b64decode(array["f4"]), "<f4").astype(float) + array["middle"]


def test_equal_steps_are_three_numbers():
    t = 5.0 + 1e-3 * np.arange(10_001)

    assert set(encoded(t)) == {"first", "step", "n"}
    assert decoded(encoded(t)) == pytest.approx(t, abs=1e-12)


def test_a_small_motion_about_a_large_value_is_exact_to_its_own_range():
    """A plain 32-bit number near 1e6 would have steps of 0.06."""
    y = 1e6 + 1e-3 * np.random.default_rng(1).standard_normal(1000)

    assert np.max(np.abs(decoded(encoded(y)) - y)) <= 6e-8 * np.ptp(y) + 1.2e-10


def test_a_run_that_diverged_is_encoded_with_gaps_for_what_is_not_finite():
    y = np.array([1.0, -3e200, np.inf, np.nan])
    found = decoded(encoded(y))

    assert found[:2].tolist() == [1.0, -3e200]
    assert np.isnan(found[2:]).all()


def test_curves_over_the_same_time_share_it():
    data = json.loads(page_data({"a": [motions(), motions()]}))

    assert len(data["arrays"]) == 5  # time, ideal, three motions
    assert data["charts"]["a"][0]["curves"] == data["charts"]["a"][1]["curves"]


def test_the_data_of_a_page_cannot_end_its_element():
    data = page_data({"a": [Chart("</script><b>", "", "", [Curve("<!--", np.zeros(2), np.zeros(2))])]})

    assert "<" not in data
    assert json.loads(data)["charts"]["a"][0]["title"] == "</script><b>"


@pytest.mark.parametrize("chart", charts(), ids=lambda c: c.title)
def test_a_picture_is_an_svg_with_labels_and_units(chart):
    head, _, body = data_uri(chart).partition(",")
    text = base64.b64decode(body).decode()

    assert head == "data:image/svg+xml;base64"
    for label in (chart.title, chart.x_label, chart.y_label, *(c.label for c in chart.curves)):
        assert f">{label}<" in text


def test_the_same_chart_is_the_same_picture():
    assert data_uri(motions()) == data_uri(motions())


def test_a_picture_is_drawn_once(monkeypatch):
    """A layout of Matplotlib's draws all of it before, to measure the numbers at the axes."""
    drawn = []
    draw = Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda self, *a: [drawn.append(self), draw(self, *a)][1])

    data_uri(motions())

    assert len(drawn) == 1


def test_a_picture_grows_with_its_labels():
    t = np.arange(2.0)
    heights = []
    for n in (2, 40):
        chart = Chart("many", "t [s]", "x [m]", [Curve(f"curve {k}", t, t) for k in range(n)])
        text = base64.b64decode(data_uri(chart).partition(",")[2]).decode()
        heights.append(float(text.partition('height="')[2].partition("pt")[0]))

    assert heights[0] == 216.0  # 3 inch
    assert heights[1] > 20 * 12.0  # 20 lines of labels


def test_a_region_is_filled_with_its_hole_left_out(tmp_path):
    """A square of 10 with a hole of 4: by hand 84 % of the field is filled."""
    image = pytest.importorskip("matplotlib.image")
    gap = [np.nan]
    outer, hole = [0.0, 10.0, 10.0, 0.0], [3.0, 3.0, 7.0, 7.0]
    x, y = np.array(outer + gap + hole), np.array([0.0, 0.0, 10.0, 10.0, *gap, 3.0, 7.0, 7.0, 3.0])
    chart = Chart("", "x", "y", [], (0.0, 10.0), (0.0, 10.0), regions=[Region(x, y, "#ff0000ff")])
    pixels = image.imread(save("", [chart], tmp_path / "region.png"))  # 0 to 1
    red = pixels[..., 0] - pixels[..., 1] > 0.25
    rows, columns = np.flatnonzero(red.any(axis=1)), np.flatnonzero(red.any(axis=0))
    field = red[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]

    assert field.mean() == pytest.approx(0.84, abs=0.01)


def test_no_text_of_a_picture_is_cut_off_or_over_another_chart(monkeypatch, tmp_path):
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, **_: (drawn.append(figure), path.touch()))
    x = np.linspace(0.0, 1.0, 5)
    curves = [Curve(f"motion_simulator.signal_{i}", x, -1e5 * x - 0.5) for i in range(30)]
    many = Chart("many", "time [s]", "displacement [mm]", curves)
    save("a title\nof two lines", [*charts()[:2], many, charts()[2]], tmp_path / "picture.png")
    [figure] = drawn
    renderer = figure.canvas.get_renderer()
    boxes = [axis.get_tightbbox(renderer) for axis in figure.axes]
    title = figure._suptitle.get_window_extent(renderer)

    assert all(box.x0 >= 0.0 and box.x1 <= figure.bbox.width for box in boxes)
    assert all(upper.y0 >= lower.y1 for upper, lower in itertools.pairwise([title, *boxes]))
    assert boxes[-1].y0 >= 0.0
    assert title.y1 <= figure.bbox.height
