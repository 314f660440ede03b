"""Axes are checked; the boundary is a root."""

from __future__ import annotations

from dataclasses import replace

import matplotlib.figure
import numpy as np
import pytest

from master.analysis.measures.map_chart import BLUE, BOUNDARY, ORANGE, OWN, map_chart, points
from master.analysis.measures.map_plot import plot_map
from master.analysis.measures.sweep import parse_axis, stability_map
from master.errors import ConfigError
from tests.master.analysis.loops_of_stubs import linearisation_of
from tests.stubs import bench, gain, variables, wire


@pytest.fixture
def linearisation():
    """x+ = p x: stable below p = 1."""
    parameter = variables(("p", "parameter", {"variability": "fixed", "start": "0.5"}))
    block = gain()
    ports = block.variables + tuple(replace(v, reference=len(block.variables)) for v in parameter)
    scaled = replace(block, variables=ports, law=lambda t, h, v: {"y": v["p"] * v["u"]})
    return linearisation_of(
        bench({"a": scaled, "b": gain()}, [wire("a.y", "b.u"), wire("b.y", "a.u")], ["a", "b"])
    )


def test_the_boundary_lies_where_the_growth_is_zero(linearisation, tmp_path):
    found = stability_map(linearisation, parse_axis("a.p=0.2:1.7:4", linearisation.system))

    [(root, _)] = found.boundary
    assert root == pytest.approx(1.0, abs=1e-5)
    assert plot_map(found, "title", tmp_path / "map.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a.p", "--sweep: not an axis, got 'a.p', expected fmu.parameter=from:to:n"),
        ("a.p=0:1", "--sweep: not a range, got '0:1', expected from:to:n with n of at least 2"),
        ("a.q=0:1:3", "--sweep: no such parameter or connected input, got 'a.q', expected 'a.p' (of a.p)"),
    ],
)
def test_a_wrong_axis_is_refused(linearisation, text, fault):
    with pytest.raises(ConfigError) as caught:
        parse_axis(text, linearisation.system)

    assert caught.value.problems == [fault]


def test_a_connected_input_stands_for_a_delay(linearisation):
    axis = parse_axis("a.u=0:1:3", linearisation.system)

    assert (axis.unit, axis.wire.source.name) == ("s", "b.y")


@pytest.fixture
def two_gains():
    """x+ = p q x: stable below p q = 1; growth log(p q) over the step of 0.5 s."""
    blocks = {}
    for name in "ab":
        parameter = variables(("p", "parameter", {"variability": "fixed", "start": "0.5"}))
        block = gain()
        ports = block.variables + tuple(replace(v, reference=len(block.variables)) for v in parameter)
        blocks[name] = replace(block, variables=ports, law=lambda t, h, v: {"y": v["p"] * v["u"]})
    return linearisation_of(bench(blocks, [wire("a.y", "b.u"), wire("b.y", "a.u")], ["a", "b"]))


def test_the_shading_changes_at_the_boundary(two_gains):
    """Growth at the points of the picture: 0 at each root, where p q = 1 by hand, and of one sign beside."""
    system = two_gains.system
    found = stability_map(two_gains, parse_axis("a.p=0.5:2:4", system), parse_axis("b.p=0.3:2.1:3", system))
    x, y, growth, damping = points(found)

    roots = growth == 0.0
    assert roots.sum() == len(found.boundary) == 5  # four between rows, one between columns
    assert x[roots] * y[roots] == pytest.approx(1.0, abs=1e-5)
    assert np.all(damping[roots] == 0.0)
    assert np.array_equal(growth[~roots] > 0.0, x[~roots] * y[~roots] > 1.0)


def test_a_map_knows_where_the_system_is(two_gains):
    system = two_gains.system

    assert parse_axis("a.p=0.5:2:4", system).own == 0.5
    assert parse_axis("a.p,b.p=0.5:2:4", system).own == 0.5
    assert parse_axis("a.u=0:1:3", system).own == 0.0


@pytest.mark.parametrize("y", ["b.p=0.3:2.1:4", "b.u=0:2:3", None])
def test_every_kind_of_map_is_drawn_with_its_operating_point(two_gains, tmp_path, monkeypatch, y):
    figures = []
    save = matplotlib.figure.Figure.savefig
    monkeypatch.setattr(
        matplotlib.figure.Figure, "savefig", lambda self, *a, **k: (figures.append(self), save(self, *a, **k))
    )
    system = two_gains.system
    found = stability_map(
        two_gains, parse_axis("a.p=0.25:1.9:5", system), None if y is None else parse_axis(y, system)
    )
    plot_map(found, "title", tmp_path / "map.png")

    assert OWN in [text.get_text() for text in figures[0].legends[0].get_texts()]
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_a_boundary_that_runs_along_the_second_axis_is_found(two_gains):
    """Whatever q is in its narrow range, p decides: by hand the boundary is at p = 1/q."""
    system = two_gains.system
    found = stability_map(two_gains, parse_axis("a.p=0.5:2:3", system), parse_axis("b.p=0.9:1.1:3", system))

    assert [y for _, y in found.boundary] == pytest.approx([1.1, 1.0, 0.9])
    assert [x for x, _ in found.boundary] == pytest.approx([1 / 1.1, 1.0, 1 / 0.9], abs=1e-5)


def test_line_and_shading_meet_where_the_growth_is_zero(two_gains):
    """By hand q = 1/p, monotone: all of the line is on it, to the length of a triangle; shades end at it."""
    system = two_gains.system
    found = stability_map(two_gains, parse_axis("a.p=0.5:2:16", system), parse_axis("b.p=0.4:2.1:18", system))
    chart = map_chart(found, "map")
    line = next(curve for curve in chart.curves if curve.label == BOUNDARY)

    assert line.x * line.y == pytest.approx(1.0, abs=0.004)
    for colour, sign in ((BLUE, 1.0), (ORANGE, -1.0)):
        shades = [r for r in chart.regions if r.fill.startswith(colour)]
        assert len(shades) == 5
        for r in shades:
            inside = np.isfinite(r.x)
            assert np.all(sign * (1.0 - r.x[inside] * r.y[inside]) > -0.004)


def test_a_delay_alone_is_swept(two_gains):
    """x(k + 1 + d) = 0.25 x(k): growth log(0.25)/(1 + d), which no delay makes positive."""
    found = stability_map(two_gains, parse_axis("b.u=0:4:9", two_gains.system))
    chart = map_chart(found, "delay")

    assert found.boundary == ()
    assert found.growth[0] == pytest.approx(np.log(0.25) / (1.0 + found.x.values), rel=1e-9)
    assert [curve.label for curve in chart.curves] == ["growth of the fastest pole", OWN]
    assert [r.fill[:7] for r in chart.regions] == [BLUE]
