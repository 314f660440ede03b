"""A connection that carries factor, offset and map: what the target gets, and what is refused."""

import pytest

from master.errors import ConfigError
from master.fmi.units import Conversion, Unit
from master.system.config import load_config
from tests.stubs.bench import bench, wire
from tests.stubs.blocks import clock, gain, typed

MILLIMETRE = Unit("mm", {"m": 1}, factor=1e-3)
METRE = Unit("m", {"m": 1})


def column(found, signal):
    return found.run(4).result[signal].tolist()


@pytest.mark.parametrize("compiled", [False, True])
def test_the_target_gets_factor_times_the_value_plus_offset(compiled):
    found = bench({"c": clock(), "g": gain()}, [wire("c.t", "g.u", factor=10.0, offset=1.0)], ["c", "g"])

    assert found.run(3, compiled=compiled).result["g.y"].tolist() == [1.0, 11.0, 21.0, 31.0]


def test_a_factor_acts_on_the_value_in_the_unit_of_the_target():
    blocks = {"a": gain(source=MILLIMETRE), "b": gain(target=METRE)}
    start = {"a": {"u": 2000.0}}
    found = bench(blocks, [wire("a.y", "b.u", factor=3.0, offset=1.0)], ["a", "b"], start=start)

    assert column(found, "b.y") == [7.0] * 5  # 3 * (2000 mm = 2 m) + 1


def test_ignored_units_let_the_number_pass():
    blocks = {"a": gain(source=MILLIMETRE), "b": gain(target=Unit("kg", {"kg": 1}))}
    found = bench(blocks, [wire("a.y", "b.u", units="ignored")], ["a", "b"], start={"a": {"u": 2.0}})

    assert column(found, "b.y") == [2.0] * 5


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(("delay", "expected"), [(0, [7, 1, 9, 3]), (1, [7, 7, 1, 9])])
def test_a_map_replaces_the_values_that_it_names_and_keeps_others(compiled, delay, expected):
    connections = [wire("a.count", "b.i", map={0: 7, 2: 9}, delay=delay)]
    found = bench({"a": typed(), "b": typed()}, connections, ["a", "b"])

    assert found.run(3, compiled=compiled).result["b.i_out"].tolist() == expected


def test_a_map_comes_before_factor_and_offset():
    found = bench({"a": typed(), "b": typed()}, [wire("a.count", "b.i", map={1: 5}, factor=2, offset=1)])

    assert column(found, "b.i_out") == [1, 11, 5, 7, 9]


def test_a_map_inverts_a_boolean():
    found = bench({"a": typed(), "b": typed()}, [wire("a.b_out", "b.b", map={0: 1, 1: 0})])

    assert column(found, "b.b_out") == [1.0] * 5


def test_a_map_on_reals_is_refused():
    with pytest.raises(
        ConfigError, match=r"a map is for integers, Booleans and enumerations, got c\.t \(Real\)"
    ):
        bench({"c": clock(), "g": gain()}, [wire("c.t", "g.u", map={0: 1})])


def test_a_map_within_an_iterated_group_is_refused():
    connections = [wire("a.i_out", "b.i", map={0: 1}), wire("b.i_out", "a.i")]
    with pytest.raises(ConfigError, match=r"an iterated connection has no map, got a\.i_out -> b\.i"):
        bench({"a": typed(), "b": typed()}, connections, [{"iterate": ["a", "b"]}])


def test_two_maps_follow_each_other():
    first = Conversion(table=((0.0, 1.0), (2.0, 3.0)))
    second = Conversion(table=((1.0, 5.0), (4.0, 6.0)))
    joined = first.then(second)

    assert [joined.of(v) for v in (0.0, 1.0, 2.0, 3.0, 4.0, 9.0)] == [5.0, 5.0, 3.0, 3.0, 6.0, 9.0]


def test_a_yaml_file_gives_all_of_them(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text(
        "name: s\nstop_time: 1\nfmus: {a: {source: spacecraft}}\nconnections:\n"
        "  - {from: a.x, to: a.y, units: ignored, factor: 2e3, offset: -1, map: {0: 1, -2: 5}}\n"
    )
    [connection] = load_config(path).config.connections

    assert (connection.units, connection.factor, connection.offset) == ("ignored", 2000.0, -1.0)
    assert connection.map == {0: 1, -2: 5}


def test_a_map_cannot_follow_a_factor():
    with pytest.raises(ValueError, match="a mapping after a linear transformation"):
        Conversion(2.0).then(Conversion(table=((0.0, 1.0),)))
