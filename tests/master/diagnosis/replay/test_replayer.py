"""A replay is a run over measured inputs: same values, and a failure keeps its reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from master.diagnosis.replay.replayer import Link, Player
from master.errors import ConfigError, FmuError
from master.fmi.value_types import FLOAT32, FLOAT64, INT64, UINT8
from tests.stubs import (
    ERROR,
    EXCHANGE,
    FATAL,
    KELVIN,
    METRE,
    MILLIMETRE,
    Block,
    Stub,
    failing,
    gain,
    integrator,
    typed,
    variables,
)

STEP = 0.5


class Refusing(Stub):
    """A stub whose setter of reals answers with a status from its n-th call on."""

    def __init__(self, name, description, law, status, after):
        self.left, self.status = after, status
        super().__init__(name, description, law)

    def _make_c_functions(self):
        made = super()._make_c_functions()
        plain = made["set", FLOAT64]

        def setter(*given):
            self.left -= 1
            return self.status if self.left < 0 else plain(*given)

        return made | {("set", FLOAT64): EXCHANGE[self.description.version](setter)}


class Uninitialised(Stub):
    """A stub that refuses to leave initialisation."""

    def exit_initialisation(self):
        raise FmuError(self.name, "the rope is torn before the start", status="error")


def player_of(blocks, links, make=None):
    """A chain of stubs; `links` gives measured, wired and read by name."""
    made = {}

    def factory(name, description):
        kind = (make or {}).get(name, Stub)
        made[name] = kind(name, description, blocks[name].law)
        return made[name]

    chain = [Link(name, blocks[name].description(name), *links[name]) for name in blocks]
    return Player(chain, factory), made


def two(version=2):
    """An integrator of a measured force, and three times its state."""
    blocks = {"x": replace(integrator(), version=version), "g": replace(gain(3.0), version=version)}
    return blocks, {"x": ({"u": 0}, {}, ("x",)), "g": ({}, {"u": "x.x"}, ("y",))}


DATA = np.array([[0.0], [1.0], [-2.0], [4.0], [8.0], [16.0], [32.0]])


@pytest.mark.parametrize("version", [2, 3])
def test_a_replay_takes_the_measured_value_at_the_end_of_each_step(version):
    player, _ = player_of(*two(version))
    rows = player.play({"x": {"x": 10.0}}, DATA, (0, 6), STEP)

    x = 10.0 + STEP * np.array([0.0, 1.0, -1.0, 3.0, 11.0, 27.0, 59.0])
    assert player.names == ["x.x", "g.y"]
    assert rows.tolist() == np.column_stack([x, 3.0 * x]).tolist()
    assert player.failure is None


def test_a_stretch_begins_at_its_row_and_gives_every_nth_step():
    player, _ = player_of(*two())
    rows = player.play({"x": {"x": 10.0}}, DATA, (1, 4), STEP, every=2)

    assert rows[:, 0].tolist() == [10.0, 10.0 + STEP * 2.0, 10.0 + STEP * 26.0]


def test_a_replay_again_gives_the_same_rows_whatever_was_replayed_between():
    player, _ = player_of(*two())
    first = player.play({"x": {"x": 1.0}}, DATA, (0, 6), STEP)
    player.play({"x": {"x": 7.0}}, DATA, (2, 3), STEP)

    assert np.array_equal(player.play({"x": {"x": 1.0}}, DATA, (0, 6), STEP), first)


@pytest.mark.parametrize("types", [(2,), (3, INT64), (3, UINT8, FLOAT32)])
def test_a_replay_passes_every_type(types):
    links = {"t": ({"i": 0, "b": 1, "r": 2}, {}, ("i_out", "b_out", "r_out", "count"))}
    player, _ = player_of({"t": typed(*types)}, links)
    data = np.array([[1.0, 0.0, 0.5], [2.0, 1.0, 1.5], [3.0, 0.0, 2.5]])

    assert player.play({}, data, (0, 2), STEP).tolist() == [
        [1.0, 0.0, 0.5, 0.0],
        [2.0, 1.0, 1.5, 1.0],
        [3.0, 0.0, 2.5, 2.0],
    ]


def test_units_of_a_wire_are_converted():
    blocks = {"a": gain(source=METRE), "b": gain(target=MILLIMETRE)}
    links = {"a": ({"u": 0}, {}, ("y",)), "b": ({}, {"u": "a.y"}, ("y",))}
    player, _ = player_of(blocks, links)

    assert player.play({}, DATA, (0, 2), STEP)[:, 1].tolist() == [0.0, 1000.0, -2000.0]


def test_units_of_a_wire_that_differ_are_refused():
    blocks = {"a": gain(source=METRE), "b": gain(target=KELVIN)}
    links = {"a": ({"u": 0}, {}, ("y",)), "b": ({}, {"u": "a.y"}, ("y",))}

    with pytest.raises(ConfigError, match=r"b\.u: units differ, got m -> K"):
        player_of(blocks, links)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("status", [ERROR, 2, 5, 77, 99, -1])
def test_a_setter_that_fails_ends_the_replay_with_its_reason(version, status):
    blocks, links = two(version)
    refusing = {"x": lambda *given: Refusing(*given, status, after=2)}
    player, _ = player_of(blocks, links, refusing)
    rows = player.play({}, DATA, (0, 6), STEP)

    # the first two steps set their inputs; initialisation does not pass here
    assert np.isfinite(rows).all(axis=1).tolist() == [True, True, True, False, False, False, False]
    assert (player.failure.instance, player.failure.row) == ("x", 3)
    assert "x at t=1 s: the setter of its inputs answered with status" in player.failure.message
    assert str(status) in player.failure.message or player.failure.status in player.failure.message


def test_a_step_that_fails_keeps_status_fmu_message_and_row():
    blocks = {"bad": failing(1.5, ERROR, "rope torn")}
    player, _ = player_of(blocks, {"bad": ({}, {}, ("t",))})
    rows = player.play({}, np.zeros((9, 0)), (0, 8), STEP)

    assert np.isfinite(rows[:, 0]).tolist() == [True] * 4 + [False] * 5
    failure = player.failure
    assert (failure.instance, failure.status, failure.row) == ("bad", "error", 4)
    assert str(failure) == "row 4: bad at t=1.5 s: rope torn"


@pytest.mark.parametrize("version", [2, 3])
def test_an_initialisation_that_fails_gives_no_row_and_its_reason(version):
    player, _ = player_of(*two(version), {"g": Uninitialised})
    rows = player.play({}, DATA, (0, 6), STEP)

    assert np.isnan(rows).all()
    assert (player.failure.instance, player.failure.status, player.failure.row) == ("g", "error", 0)
    assert "torn before the start" in player.failure.message


def test_an_fmu_is_loaded_again_after_a_fatal_status():
    blocks = {"bad": failing(1.5, FATAL, "gone")}
    player, made = player_of(blocks, {"bad": ({}, {}, ("t",))})
    first = made["bad"]
    player.play({}, np.zeros((9, 0)), (0, 8), STEP)
    assert (player.failure.status, first.events[-1]) == ("fatal", "abandoned")

    rows = player.play({}, np.zeros((9, 0)), (0, 2), STEP)

    assert made["bad"] is not first
    assert (rows[:, 0].tolist(), player.failure) == ([0.0, 0.5, 1.0], None)


def test_a_value_that_is_not_finite_is_named_and_the_rows_go_on():
    law = Block(lambda t, h, v: {"y": np.inf if t == 1.0 else t}, variables(("y", "output")))
    player, _ = player_of({"a": law}, {"a": ({}, {}, ("y",))})
    rows = player.play({}, np.zeros((7, 0)), (0, 6), STEP)

    assert rows[:, 0].tolist() == [0.0, 0.0, 0.5, np.inf, 1.5, 2.0, 2.5]
    assert (player.failure.row, player.failure.status) == (3, "not finite")
    assert "a.y is not a number or infinite" in player.failure.message
