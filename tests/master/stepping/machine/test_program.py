import pytest

from master.stepping.compiler import build_program
from master.stepping.machine.interpreter import is_plain
from master.stepping.machine.program import COPY, KEEP, STEP
from tests.stubs import CELSIUS, KELVIN, bench, clock, gain, typed, wire

WORDS = {COPY: "copy", KEEP: "keep", STEP: "step"}


@pytest.fixture
def program_of():
    def build(*arguments, **options):
        made = bench(*arguments, **options)
        slaves = {n: made.factory(n, i.description) for n, i in made.system.instances.items()}
        program = build_program(made.system, made.schedule, slaves)
        program.made = made  # the slaves own the C functions
        return program

    return build


def words(program):
    """Operations in order, with the FMU that each belongs to."""
    return [
        WORDS[row[0]] if row[0] in (COPY, KEEP) else f"{WORDS[row[0]]} {program.instance_of(i)}"
        for i, row in enumerate(program.memory.operations)
    ]


def blocks_of(program, name):
    """Numbers of calls that set and get the variables of an FMU in a step."""
    *_, set_first, set_end, get_first, get_end, _ = program.memory.slaves[program.names.index(name)]
    return set_end - set_first, get_end - get_first


def test_an_fmu_without_wires_steps_and_is_read(program_of):
    assert words(program_of({"a": clock()})) == ["step a"]


def test_in_a_sequence_a_value_moves_between_the_steps(program_of):
    program = program_of({"a": clock(), "b": gain()}, [wire("a.t", "b.u")])

    assert words(program) == ["step a", "copy", "step b"]


def test_side_by_side_all_values_move_before_the_steps(program_of):
    wires = [wire("a.y", "b.u"), wire("b.y", "a.u")]
    program = program_of({"a": gain(), "b": gain()}, wires, [["a", "b"]])

    assert words(program) == ["copy", "step a", "step b"]
    assert len(program.memory.copies) == 2


def test_a_delayed_value_is_kept_and_copied_only_to_convert(program_of):
    blocks = {"a": gain(source=CELSIUS), "b": gain(target=KELVIN), "c": gain()}
    program = program_of(blocks, [wire("a.y", "b.u", delay=2), wire("a.y", "c.u", delay=3)])

    assert words(program)[1:3] == ["keep", "copy"]
    assert words(program).count("keep") == 2
    assert words(program).count("copy") == 1
    assert program.memory.rings.size == 5


def test_rings_start_from_the_present_values(program_of):
    program = program_of({"a": clock(), "b": gain()}, [wire("a.t", "b.u", delay=3)])
    program.memory.values[program.place["a.t"]] = 7.0
    program.fill_rings()

    assert program.memory.rings.tolist() == [7.0, 7.0, 7.0]


def test_each_type_is_exchanged_in_one_call(program_of):
    blocks = {"a": typed(), "b": typed()}
    wires = [wire(f"a.{n}_out", f"b.{n}") for n in ("i", "b", "r")] + [wire("b.count", "a.r")]
    program = program_of(blocks, wires, ["a", "b"])

    assert blocks_of(program, "b") == (3, 3)
    assert [n for n in program.memory.blocks[:, 2] if n == 2] == [2, 2]


def test_every_port_in_use_has_a_place_of_its_own(program_of):
    program = program_of({"a": clock(), "b": gain()}, [wire("a.t", "b.u")])

    assert sorted(program.place) == ["a.t", "b.u", "b.y"]
    assert sorted(program.place.values()) == [0, 1, 2]


def test_a_program_of_steps_and_copies_is_plain(program_of):
    wires = [wire("a.t", "b.u")]

    assert is_plain(program_of({"a": clock(), "b": gain()}, wires).memory)
    assert not is_plain(program_of({"a": clock(), "b": gain()}, [wire("a.t", "b.u", delay=1)]).memory)
