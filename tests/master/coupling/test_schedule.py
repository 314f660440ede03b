import os
import subprocess
import sys
from pathlib import Path

import pytest

from master.errors import ConfigError
from tests.stubs import bench, clock, gain, integrator, wire

PROJECT = Path(__file__).parents[3]
LOOP = [wire("a.x", "b.u"), wire("b.x", "a.u")]


def faults(blocks, connections, order):
    with pytest.raises(ConfigError) as caught:
        bench(blocks, connections, order)
    return caught.value.problems


def two():
    return {"a": integrator(), "b": integrator()}


def test_without_an_order_fmus_step_along_the_wires():
    blocks = {"last": gain(), "middle": gain(), "first": clock()}
    made = bench(blocks, [wire("middle.y", "last.u"), wire("first.t", "middle.u")])

    assert made.schedule.members == (("first",), ("middle",), ("last",))


def test_where_the_wires_leave_it_open_the_order_of_the_file_holds():
    made = bench({name: clock() for name in ("d", "a", "c", "b")})

    assert made.schedule.members == (("d",), ("a",), ("c",), ("b",))


def test_a_delayed_wire_does_not_bind_the_order():
    made = bench(two(), [wire("a.x", "b.u"), wire("b.x", "a.u", delay=1)])

    assert made.schedule.members == (("a",), ("b",))


def test_a_loop_needs_an_order():
    [fault] = faults(two(), LOOP, None)

    assert fault in {
        f"coupling.order: missing although the system has a loop, got {loop}, expected the order of stepping"
        for loop in ("a -> b -> a", "b -> a -> b")
    }


def test_a_given_order_is_kept_with_its_groups():
    made = bench({**two(), "c": clock()}, LOOP, ["c", ["b", "a"]])

    assert made.schedule.members == (("c",), ("b", "a"))
    assert [made.schedule.group_of(name) for name in "abc"] == [1, 1, 0]


def test_an_order_names_every_fmu_once():
    assert faults(two(), LOOP, ["a", ["a", "bb"]]) == [
        "coupling.order: no such FMU, got 'bb', expected 'b' (of a, b)",
        "coupling.order: stands twice, got 'a', expected each FMU once",
        "coupling.order: incomplete, got no b, expected every FMU once",
    ]


SCRIPT = """
from stubs import bench, clock, gain, wire
names = ["force", "mass", "rope", "axis", "pin"]
blocks = {"clock": clock()} | {name: gain() for name in names}
made = bench(blocks, [wire("clock.t", f"{n}.u") for n in names[:3]] + [wire("rope.y", "axis.u")])
print(made.schedule.members, made.ledger.entries)
"""


def test_order_and_ledger_do_not_depend_on_hashing():
    printed = set()
    for seed in ("0", "1", "2"):
        paths = os.pathsep.join(str(p) for p in (PROJECT, PROJECT / "tests"))
        environment = os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": paths}
        done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        printed.add(done.stdout)

    assert len(printed) == 1
