"""Cutting a system where signals were measured."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from master.diagnosis.case.cut import MeasuredInput, _parts
from master.fmi.units import Conversion
from master.system.graph import Wire

HELD = {"input_hold": None}


def system(connections, holds=(), direct=()):
    """
    A system of FMUs with the connections (`a.y`, `b.u`).

    Those in `holds` interpolate their inputs; the outputs of those in `direct` follow the input `u` at once.
    """
    names = dict.fromkeys(port.partition(".")[0] for wire in connections for port in wire)

    def port(name):
        instance, _, variable = name.partition(".")
        return SimpleNamespace(name=name, instance=instance, variable=SimpleNamespace(name=variable))

    def description(name):
        return SimpleNamespace(
            by_name=HELD if name in holds else {},
            hands_through=lambda variable, output: name in direct and variable == "u",
        )

    return SimpleNamespace(
        wires=[Wire(port(a), port(b), 0, Conversion()) for a, b in connections],
        instances={name: SimpleNamespace(description=description(name)) for name in names},
    )


def case(inputs, compared):
    """A case with inputs of a signal, or of a signal and its row."""
    given = {key: value if isinstance(value, tuple) else (value, None) for key, value in inputs.items()}
    entries = {key: SimpleNamespace(signal=signal, at=row) for key, (signal, row) in given.items()}
    return SimpleNamespace(case=SimpleNamespace(inputs=entries, compared=compared))


def test_what_carries_a_signal_to_a_foreign_file_hands_it_the_row_that_this_takes():
    """The file holds its input over the step: it would get the value of the row at its end otherwise."""
    loaded = case({"a.u": "s"}, {"b.y": "s1"})
    chain = system([("a.y", "b.u")], holds=["a"], direct=["a"])

    [own] = _parts(loaded, chain, ["a", "b"])
    [carried] = _parts(loaded, chain, ["a", "b"], foreign=["b"])

    assert own.inputs["a"]["u"] == MeasuredInput("s", "end")
    assert carried.inputs["a"]["u"] == MeasuredInput("s", "start")


CHAIN = [("a.y", "b.u"), ("b.y", "c.u"), ("c.y", "a.u")]


def test_a_loop_that_is_measured_everywhere_falls_into_its_fmus():
    loaded = case({"a.u": "s3", "b.u": "s1", "c.u": "s2"}, {"a.y": "s1", "b.y": "s2", "c.y": "s3"})

    parts = _parts(loaded, system(CHAIN), ["a", "b", "c"])

    assert [p.name for p in parts] == ["a", "b", "c"]
    assert all(wires == {} for p in parts for wires in p.wired.values())
    assert [p.compared for p in parts] == [{"a.y": "s1"}, {"b.y": "s2"}, {"c.y": "s3"}]


def test_fmus_that_stay_connected_are_one_part_in_the_order_of_the_system():
    loaded = case({"a.u": "s3", "c.u": "s2"}, {"b.y": "s2", "c.y": "s3"})

    first, second = _parts(loaded, system(CHAIN), ["c", "b", "a"])

    assert (first.name, second.name) == ("c", "b and a")
    assert second.wired == {"b": {"u": "a.y"}, "a": {}}
    assert second.inputs == {"b": {}, "a": {"u": MeasuredInput("s3", "start")}}
    assert second.compared == {"b.y": "s2"}


def test_what_acts_on_nothing_that_is_compared_is_left_out():
    connections = [("a.y", "b.u"), ("b.y", "watch.u")]
    loaded = case({"a.u": "s"}, {"b.y": "f"})

    [part] = _parts(loaded, system(connections), ["a", "b", "watch"])

    assert part.fmus == ("a", "b")


def test_an_fmu_that_interpolates_takes_the_row_at_the_end_unless_the_case_says_otherwise():
    connections = [("a.y", "b.u")]
    inputs = {"a.u": "s", "b.u": "f", "b.v": ("g", "start")}
    loaded = case(inputs, {"a.y": "f", "b.y": "h"})

    first, second = _parts(loaded, system(connections, holds=("b",)), ["a", "b"])

    assert first.inputs["a"] == {"u": MeasuredInput("s", "start")}
    assert second.inputs["b"] == {"u": MeasuredInput("f", "end"), "v": MeasuredInput("g", "start")}
    assert second.columns == [MeasuredInput("f", "end"), MeasuredInput("g", "start")]


def test_an_input_that_a_compared_output_follows_at_once_is_of_the_row_of_that_output():
    connections = [("a.y", "b.u")]
    loaded = case({"a.u": "s", "a.v": "t", "b.u": "f"}, {"a.y": "f", "b.y": "h"})

    first, second = _parts(loaded, system(connections, direct=("a",)), ["a", "b"])

    assert first.inputs["a"] == {"u": MeasuredInput("s", "end"), "v": MeasuredInput("t", "start")}
    assert second.inputs["b"] == {"u": MeasuredInput("f", "start")}


@pytest.mark.parametrize("order", [["a", "b", "c"], ["b", "c", "a"]])
def test_a_loop_without_a_measured_input_is_one_part(order):
    [part] = _parts(case({}, {"c.y": "s"}), system(CHAIN), order)

    assert part.fmus == tuple(order)
