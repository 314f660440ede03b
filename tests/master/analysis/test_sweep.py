"""Axes are checked; the boundary is a root."""

from __future__ import annotations

from dataclasses import replace

import pytest
from loops_of_stubs import linearisation_of
from stubs import bench, gain, variables, wire

from master.analysis.measures.map_plot import plot_map
from master.analysis.measures.sweep import parse_axis, stability_map
from master.errors import ConfigError


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
