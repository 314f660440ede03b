"""The flat program of a tick as straight-line C: the operations of the stepping loop, in its order."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from master.fmi.description import Description, Kind, Variable
from master.fmi.slave import CInterface
from master.fmi.value_types import BOOLEAN, FLOAT32, FLOAT64, INT64, INT_BOOLEAN, NAMES, RANGES
from master.stepping.compiler import build_program
from master.stepping.machine.program import BlockRow, Operation, Program
from master.system.graph import Port, Wire

from .inner import InnerModel
from .layout import Fused, Inner


@dataclass(frozen=True)
class _Plan:
    """What takes the place of a loaded FMU while its system is compiled: it has no addresses."""

    description: Description

    def interface(self) -> CInterface:
        """Addresses, all of them 0."""
        none: Mapping[tuple[Kind, int], int] = defaultdict(int)
        return CInterface(self.description.version, 0, 0, none, none)


def plan(fused: Fused) -> Program:
    """Compile the system into its flat program, without loading an FMU."""
    plans = {name: _Plan(i.description) for name, i in fused.system.instances.items()}
    channels = fused.scenario.channels()
    return build_program(fused.system, fused.schedule, plans, channels)  # type: ignore[arg-type]  # of a slave it asks no more


@dataclass(frozen=True)
class Cell:
    """One value that a step sets or gets: place in its FMU, FMI type, place in the table of values."""

    own: int
    value_type: int
    place: int


class TickWriter:
    """Writes the C of one program."""

    def __init__(self, fused: Fused, program: Program) -> None:
        self.fused = fused
        self.program = program
        self.inners = list(fused.inners.values())
        self.operations = program.operations.tolist()

    @cached_property
    def used(self) -> set[int]:
        """Places that an operation reads; what no one reads is not copied from its FMU."""
        memory = self.program.memory
        places: set[int] = set()
        for code, _, a, b, _, _ in self.operations:
            if code == Operation.COPY:
                places |= set(memory.copies[a:b, 0].tolist())
            elif code in (Operation.KEEP, Operation.COLLECT, Operation.EXTRAPOLATE, Operation.MAP):
                places.add(a)
            elif code == Operation.STEP:
                places |= {cell.place for cell in self.cells_to_set(a)}
        for source, target, _ in memory.residuals.tolist():
            places |= {source, target}
        wires = (*self.fused.system.wires, *self.let_out)
        looked_at = [e.condition.signal for e in self.fused.scenario.events if e.condition is not None]
        return places | {self.program.place[n] for n in (*(w.source.name for w in wires), *looked_at)}

    @property
    def let_out(self) -> list[Wire]:
        """Wires from FMUs to outputs of the system itself."""
        return [wire for wire in self.fused.system.outlets if wire.source.instance in self.fused.inners]

    @property
    def saved(self) -> list[Inner]:
        """FMUs whose state the program saves."""
        numbers = {a for code, _, a, *_ in self.operations if code == Operation.SAVE}
        return [self.inners[number] for number in sorted(numbers)]

    def cells_to_set(self, number: int) -> list[Cell]:
        """What a step of an FMU sets."""
        first, after = self.program.memory.slaves[number, 3:5].tolist()
        return [self._cell(number, *row) for row in self._exchanged(first, after)]

    def cells_to_get(self, number: int) -> list[Cell]:
        """What it gets, of that what an operation reads."""
        first, after = self.program.memory.slaves[number, 5:7].tolist()
        rows = self._exchanged(first, after)
        return [self._cell(number, *row) for row in rows if row[-1] in self.used]

    def _cell(self, number: int, reference: int, value_type: int, place: int) -> Cell:
        return Cell(self.inners[number].model.place_of(reference, value_type), value_type, place)

    def _exchanged(self, first: int, after: int) -> Iterator[tuple[int, int, int]]:
        """Value reference, type and place in the table of all that some blocks set or get."""
        for i in range(first, after):
            block = BlockRow(*self.program.memory.blocks[i].tolist())
            for j, reference in enumerate(self.program.keep_alive[i].tolist()):
                yield reference, block.value_type, block.place + j

    def steps(self) -> Iterator[str]:
        """A function for the step of each FMU."""
        for inner in self.inners:
            prefix, own = inner.model.prefix, f"memory->{inner.member}"
            yield f"/* {_comment(inner.name)} */"
            yield f"static bool step_{inner.member}(Memory *memory, double t, double h) {{"
            for cell in self.cells_to_set(inner.number):
                yield from self._set(inner, cell)
            yield f"    if (!{prefix}instance_step(&{own}, t, h)) {{"
            yield "        return false;"
            yield "    }"
            for cell in self.cells_to_get(inner.number):
                value = read(f"{own}.now.values[{cell.own}]", cell.value_type, inner.model)
                yield f"    memory->values[{cell.place}] = {value};"
            yield "    return true;"
            yield "}"
            yield ""

    def _set(self, inner: Inner, cell: Cell) -> Iterator[str]:
        source = f"memory->values[{cell.place}]"
        yield from checked(f"{inner.name}.{inner.model.rows[cell.own].name}", source, cell.value_type)
        target = f"memory->{inner.member}.now.values[{cell.own}]"
        yield f"    {target} = {written(source, cell.value_type)};"

    def tick(self) -> Iterator[str]:
        """The function of a tick."""
        backs = {int(row[0]) for row in self.program.memory.loops.tolist()}
        yield "bool system_tick(Memory *memory) {"
        yield "    const uint64_t k = memory->tick;"
        yield "    double *const values = memory->values;"
        yield "    double *const rings = memory->rings;"
        yield "    (void)k, (void)values, (void)rings;"
        for i, (code, every, a, b, c, d) in enumerate(self.operations):
            if i in backs:
                yield f"again_{i}:;"
            indent = "    " if every == 1 else "        "
            if every != 1:
                yield f"    if ((k + 1) % {every} == 0) {{"
            yield from (indent + line for line in self._operation(Operation(code), a, b, c, d))
            if every != 1:
                yield "    }"
        yield "    memory->tick = k + 1;"
        yield "    return true;"
        yield "}"

    def _operation(self, code: Operation, a: int, b: int, c: int, d: int) -> Iterator[str]:
        match code:
            case Operation.COPY:
                for source, target, conversion in self.program.memory.copies[a:b].tolist():
                    yield f"values[{target}] = {self._converted(f'values[{source}]', conversion)};"
            case Operation.STEP:
                t = f"memory->t0 + (double)(k + 1 - {b}) * STEP_SIZE"
                yield f"if (!step_{self.inners[a].member}(memory, {t}, {float(c)!r} * STEP_SIZE)) {{"
                yield "    return false;"
                yield "}"
            case Operation.KEEP:
                yield "{"
                yield f"    double *const cell = &rings[{c} + k % {d}];"
                yield "    const double oldest = *cell;"
                yield f"    *cell = values[{a}];"
                yield f"    values[{b}] = oldest;"
                yield "}"
            case Operation.COLLECT:
                yield f"values[{b} + k % {c}] = values[{a}];"
            case Operation.EXTRAPOLATE:
                yield from _extrapolate(a, b, c)
            case Operation.MAP:
                rows = self.program.memory.maps[c : c + d].tolist()
                yield f"values[{b}] = {mapped(f'values[{a}]', rows)};"
            case Operation.CHANNEL:
                channel = f"memory->channels[{b}], &rings[{c}], {d}"
                yield f"values[{a}] = through_channel({channel}, k, values[{a}]);"
            case Operation.SAVE:
                yield from self._call_foreign(a, "save")
                yield f"memory->saved_i{a} = memory->i{a}.now;"
            case Operation.RESTORE:
                yield from self._call_foreign(a, "restore")
                yield f"memory->i{a}.now = memory->saved_i{a};"
                yield f"memory->i{a}.is_preview_valid = false;"
            case Operation.CHECK:
                yield from self._check(a)
            case _:
                raise AssertionError(f"{code.name} is refused before")

    def _call_foreign(self, number: int, function: str) -> Iterator[str]:
        """Save or restore what an FMU that is carried along keeps to itself."""
        model = self.inners[number].model
        if model.is_foreign:
            yield f"if (!{model.prefix}{function}(&memory->i{number})) {{"
            yield "    return false;"
            yield "}"

    def _converted(self, value: str, conversion: int) -> str:
        factor, offset = self.program.memory.conversions[conversion].tolist()
        return affine(value, factor, offset)

    def _check(self, loop: int) -> Iterator[str]:
        """Go back until all wires of an iterated group agree."""
        memory = self.program.memory
        back, first, after, maximum, _ = memory.loops[loop].tolist()
        yield "{"
        yield "    Residual worst = {.ratio = 1.0};"
        for j in range(first, after):
            source, target, conversion = memory.residuals[j].tolist()
            sent = self._converted(f"values[{source}]", conversion)
            tolerance, wire = memory.tolerances[j].item(), quoted(self.program.loop_wires[j])
            yield f"    compare(&worst, {sent}, values[{target}], {tolerance!r}, {wire});"
        yield "    if (worst.wire == NULL) {"
        yield f"        memory->passes[{loop}] = 0;"
        yield f"    }} else if (memory->passes[{loop}] + 1 >= {maximum}) {{"
        yield "        return refuse_residual(memory, &worst);"
        yield "    } else {"
        yield f"        memory->passes[{loop}]++;"
        yield f"        goto again_{back};"
        yield "    }"
        yield "}"

    def first_values(self) -> Iterator[str]:
        """Fill the table of values and all that holds older ones, after initialisation."""
        yield "static void fill_values(Memory *memory) {"
        yield "    double *const values = memory->values;"
        yield "    double *const rings = memory->rings;"
        yield "    (void)values, (void)rings;"
        place = self.program.place
        for inner in self.inners:
            for cell in self.cells_to_get(inner.number):
                value = read(f"memory->{inner.member}.now.values[{cell.own}]", cell.value_type, inner.model)
                yield f"    values[{cell.place}] = {value};"
        for wire in (*self.fused.system.wires, *self.let_out):
            source = f"values[{place[wire.source.name]}]"
            yield f"    values[{place[wire.target.name]}] = {carried(source, wire.conversion)};"
        for code, _, a, b, c, d in self.operations:
            if code == Operation.KEEP:
                yield f"    fill(&rings[{c}], {d}, values[{a}]);"
            elif code == Operation.COLLECT:
                yield f"    fill(&values[{b}], {c}, values[{a}]);"
            elif code == Operation.EXTRAPOLATE:
                yield f"    fill(&rings[{c}], {b}, values[{a}]);"
            elif code == Operation.CHANNEL:
                yield f"    fill(&rings[{c}], {d}, values[{a}]);"
                yield f"    memory->channels[{b}][CHANNEL_HELD] = values[{a}];"
        yield "}"


def _extrapolate(target: int, order: int, first: int) -> Iterator[str]:
    """See `master.coupling.extrapolation.one_step_on`."""
    yield "{"
    yield f"    const double value = values[{target}];"
    yield f"    const double last = rings[{first}];"
    yield f"    rings[{first}] = value;"
    if order == 1:
        yield f"    values[{target}] = 2.0 * value - last;"
    else:
        yield f"    const double before = rings[{first + 1}];"
        yield f"    rings[{first + 1}] = last;"
        yield f"    values[{target}] = 3.0 * value - 3.0 * last + before;"
    yield "}"


def number(value: float) -> str:
    """Write a double as C reads it back."""
    return repr(value) if value >= 0.0 else f"({value!r})"


def affine(value: str, factor: float, offset: float) -> str:
    """Convert as the operation COPY does, which adds an offset of 0 too: it takes the sign of a zero."""
    scaled = value if factor == 1.0 else f"{number(factor)} * {value}"
    return f"{scaled} + {number(offset)}"


def mapped(value: str, rows: Sequence[Sequence[float]]) -> str:
    """Put the second of a pair in the place of a value that is the first one."""
    chosen = "".join(f"{value} == {number(a)} ? {number(b)} : " for a, b in rows)
    return f"({chosen}{value})"


def carried(value: str, conversion) -> str:  # type: ignore[no-untyped-def]
    """Convert as a wire does at the start, where a plain one changes nothing."""
    through = mapped(value, conversion.table) if conversion.table else value
    return affine(through, conversion.factor, conversion.offset) if conversion.is_scaled else through


def read(value: str, value_type: int, model: InnerModel) -> str:
    """What a getter gives of a value of an FMU, as a double."""
    if value_type == FLOAT64 or model.is_foreign:  # whose values were got by its own getters
        return value
    if value_type in (BOOLEAN, INT_BOOLEAN):
        return f"(double)({value} != 0.0)"
    return f"{'long' if value_type == INT64 else 'integer'}_of({value})"


def written(value: str, value_type: int) -> str:
    """What a setter makes of a double."""
    if value_type == FLOAT64:
        return value
    if value_type in (BOOLEAN, INT_BOOLEAN):
        return f"(double)({value} != 0.0)"
    return f"(double)(float)({value})" if value_type == FLOAT32 else f"nearbyint({value})"


def checked(name: str, value: str, value_type: int) -> Iterator[str]:
    """Refuse a value that an integer type does not hold."""
    if value_type in (FLOAT64, FLOAT32, BOOLEAN, INT_BOOLEAN):
        return
    least, largest = RANGES[value_type]
    yield f"    if (!({number(least)} <= nearbyint({value}) && nearbyint({value}) <= {number(largest)})) {{"
    yield f"        return refuse_misfit(memory, {quoted(name)}, {quoted(NAMES[value_type])}, {value});"
    yield "    }"


def quoted(text: str) -> str:
    """Write a C string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("?", "\\?").replace("\n", "\\n")
    return f'"{escaped}"'


def _comment(text: str) -> str:
    return text.replace("*/", "* /").replace("\n", " ")


def type_of(port: Port) -> int:
    """FMI type of a port."""
    variable: Variable = port.variable
    return variable.value_type
