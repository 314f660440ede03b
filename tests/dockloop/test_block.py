"""Blocks: what is declared is checked at once, with all faults."""

from __future__ import annotations

import pytest

import dockloop as dl


def test_all_faults_of_a_declaration_are_said_at_once():
    with pytest.raises(dl.ConfigError) as error:
        dl.block({"u": "furlong"}, {"u": "m", "y": (float("nan"), "m")}, lambda t: {})

    assert [p.where for p in error.value.problems] == [
        "block: u",
        "block: input u",
        "block: output y",
        "block: step",
    ]


def test_names_alone_have_no_unit():
    block = dl.block(["u"], ["y"], lambda t, h, values: {"y": 2 * values["u"]})

    assert [(v.name, v.unit_name, v.causality) for v in block.variables] == [
        ("u", "1", "input"),
        ("y", "1", "output"),
    ]


def test_a_value_that_is_no_output_is_a_failure():
    block = dl.block(["u"], ["y"], lambda t, h, values: {"z": 1.0})

    with pytest.raises(dl.FmuError, match="step returns 'z', expected an output"):
        dl.load({"name": "x", "stop_time": 0.01, "fmus": {"b": block}}).run()


def test_units_of_blocks_are_converted_on_wires():
    metres = dl.block((), {"y": (2.0, "m")}, lambda t, h, u: {})
    millimetres = dl.block({"u": "mm"}, {"y": "mm"}, lambda t, h, u: {"y": u["u"]})
    system = dl.load(
        {
            "name": "x",
            "stop_time": 0.002,
            "fmus": {"a": metres, "b": millimetres},
            "connections": [{"from": "a.y", "to": "b.u"}],
        }
    )

    assert system.run()["b.y"].tolist() == [0.0, 2000.0, 2000.0]


def test_an_iterated_group_solves_a_loop_with_a_block():
    """Y = 1 + u/2, u = y: the only solution is 2."""
    half = dl.block(["u"], ["y"], lambda t, h, values: {"y": 1.0 + 0.5 * values["u"]})
    same = dl.block(["u"], ["y"], lambda t, h, values: {"y": values["u"]})
    system = dl.load(
        {
            "name": "loop",
            "stop_time": 0.002,
            "fmus": {"a": half, "b": same},
            "connections": [{"from": "a.y", "to": "b.u"}, {"from": "b.y", "to": "a.u"}],
            "coupling": {"order": [{"iterate": ["a", "b"], "tolerance": 1e-12, "maximum": 100}]},
        }
    )

    assert system.run()["a.y"][-1] == pytest.approx(2.0, abs=1e-9)
