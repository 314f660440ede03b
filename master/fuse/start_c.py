"""Initialisation as C: the passes over the wires that `stepping.initialisation` makes, in its order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from master.system.graph import Wire

from .events_c import EventWriter
from .foreign import ForeignModel
from .layout import INPUT, OUTPUT, PARAMETER, STATE, Fused, Inner, InnerVariable
from .program_c import carried, checked, number, quoted, read, written


class StartWriter:
    """Writes the C that leads a system from its start values to its first row."""

    def __init__(self, fused: Fused, events: EventWriter) -> None:
        self.fused = fused
        self.events = events
        self.place = events.place
        self.inners = list(fused.inners.values())
        self.numbers = {wire.target.name: i for i, wire in enumerate(fused.system.wires)}

    def lines(self) -> Iterator[str]:
        """All functions of the start."""
        yield from self._attach()
        yield from self._take()
        yield from self._publish()
        for inner in self.inners:
            if self.fused.system.wires_into(inner.name):
                yield from self._pull(inner)
        yield from self._start()

    def _attach(self) -> Iterator[str]:
        """Pointers are set whenever work begins: those in the bytes of a saved state are of another time."""
        yield "void system_attach(Memory *memory) {"
        yield "    memory->message.length = 0;"
        for inner in self.inners:
            own = f"memory->{inner.member}"
            yield f"    {own}.name = (char *){quoted(inner.name)};"
            yield f"    {own}.environment = &memory->message;"
            yield f"    {own}.log = {inner.model.prefix}say;"
        yield "}"
        yield ""

    def _take(self) -> Iterator[str]:
        yield "void system_take_inputs(Memory *memory, const double *values) {"
        yield "    (void)memory, (void)values;"
        for i, v in enumerate(self.fused.variables):
            if v.role == INPUT and isinstance(v, InnerVariable):
                yield f"    memory->{v.inner.member}.now.values[{v.place}] = values[{i}];"
        for wire in self.fused.system.inlets:
            yield from self._handed_in(wire)
        yield from self._overlaid()
        yield "}"
        yield ""
        yield "void system_take_parameters(Memory *memory, const double *values) {"
        first = 0
        for inner in self.inners:
            n = inner.model.first(INPUT)
            own = f"memory->{inner.member}.now"
            yield f"    memcpy({own}.values, values + {first}, {n} * sizeof(double));"
            yield f"    {own}.is_unchecked = 1;"
            first += n
        yield from self._overlaid()
        yield "}"
        yield ""
        yield "static void take_states(Memory *memory, const double *values) {"
        reference = sum(v.role in (PARAMETER, INPUT) for v in self.fused.variables)
        for inner in self.inners:
            place = inner.model.first(STATE)
            n = inner.model.first(OUTPUT) - place
            if n:
                own = f"memory->{inner.member}.now.values + {place}"
                yield f"    memcpy({own}, values + {reference}, {n} * sizeof(double));"
            reference += n
        yield "}"
        yield ""

    def _overlaid(self) -> Iterator[str]:
        """What events set holds over what the importer set."""
        if self.fused.scenario.events:
            yield "    overlay(memory);"

    def _handed_in(self, wire: Wire) -> Iterator[str]:
        """Let an input of an FMU have what the importer set for the whole system."""
        inner = self.fused.inners[wire.target.instance]
        variable = wire.target.variable
        value = carried(f"values[{self.fused.reference_of[wire.source.name]}]", wire.conversion)
        target = f"memory->{inner.member}.now.values[{inner.model.place(variable)}]"
        yield f"    {target} = {written(value, variable.value_type)};"

    def _publish(self) -> Iterator[str]:
        """Only what a host may see: the cells of a delay line, for example, stay where they are."""
        yield "void system_publish(const Memory *memory, double *values) {"
        yield "    (void)memory, (void)values;"
        first, n = 0, 0
        shown = [
            i
            for i, v in enumerate(self.fused.variables)
            if isinstance(v, InnerVariable) and v.role in (STATE, OUTPUT) and v.described
        ]
        for reference in shown:
            if n and self._follow(first + n - 1, reference):
                n += 1
                continue
            yield from self._shown(first, n)
            first, n = reference, 1
        yield from self._shown(first, n)
        for wire in self.fused.system.outlets:
            target = f"values[{self.fused.reference_of[wire.target.name]}]"
            if wire.source.instance in self.fused.inners:
                yield f"    {target} = memory->values[{self.place[wire.target.name]}];"
            else:
                handed = f"values[{self.fused.reference_of[wire.source.name]}]"
                yield f"    {target} = {carried(handed, wire.conversion)};"
        yield "}"
        yield ""

    def _follow(self, last: int, reference: int) -> bool:
        """Whether two variables are neighbours in the fused FMU and in their own."""
        one, other = self._own(last), self._own(reference)
        return reference == last + 1 and one.inner is other.inner and other.place == one.place + 1

    def _own(self, reference: int) -> InnerVariable:
        v = self.fused.variables[reference]
        assert isinstance(v, InnerVariable), "only variables of FMUs are shown in rows"
        return v

    def _shown(self, first: int, n: int) -> Iterator[str]:
        if n:
            v = self._own(first)
            own = f"memory->{v.inner.member}.now.values + {v.place}"
            yield f"    memcpy(values + {first}, {own}, {n} * sizeof(double));"

    def _pull(self, inner: Inner) -> Iterator[str]:
        """Set the inputs of one FMU to its sources' present values; true if any of them moved."""
        wires = self.fused.system.wires_into(inner.name)
        others = [w for w in wires if w.source.instance != inner.name]
        own = [[w] for w in wires if w.source.instance == inner.name]
        yield f"static bool pull_{inner.member}(Memory *memory, Sent *sent, bool *has_moved) {{"
        for part in filter(None, (others, *own)):
            yield "    {"
            yield from (f"    {line}" for line in self._send(inner, part))
            yield "    }"
        yield "    return true;"
        yield "}"
        yield ""

    def _send(self, inner: Inner, wires: Sequence[Wire]) -> Iterator[str]:
        """Read all sources, then set the inputs whose value changed."""
        for instance in dict.fromkeys(wire.source.instance for wire in wires):
            source = self.fused.inners[instance]
            prefix, own = source.model.prefix, source.member
            yield f"    const {prefix}Data *{own} = {prefix}instance_readable(&memory->{own});"
            yield f"    if ({source.member} == NULL) {{"
            yield "        return false;"
            yield "    }"
        for wire in wires:
            i = self.numbers[wire.target.name]
            variable = wire.source.variable
            source = self.fused.inners[wire.source.instance]
            cell = f"{source.member}->values[{source.model.place(variable)}]"
            value = f"value_{i}"
            yield f"    const double taken_{i} = {read(cell, variable.value_type, source.model)};"
            yield f"    const double {value} = {carried(f'taken_{i}', wire.conversion)};"
        for wire in wires:
            i = self.numbers[wire.target.name]
            value, variable = f"value_{i}", wire.target.variable
            tolerance = number(self.fused.schedule.tolerance_of(wire))
            target = f"memory->{inner.member}.now.values[{inner.model.place(variable)}]"
            yield f"    if (is_new(&sent[{i}], {value}, {tolerance}, has_moved)) {{"
            yield from (f"    {line}" for line in checked(wire.target.name, value, variable.value_type))
            yield f"        {target} = {written(value, variable.value_type)};"
            yield f"        memory->{inner.member}.is_preview_valid = false;"
            if isinstance(inner.model, ForeignModel):
                cell = f"(ForeignCell){inner.model.cell(variable)}"
                yield f"        if (!{inner.model.prefix}set(&memory->{inner.member}, {cell})) {{"
                yield "            return false;"
                yield "        }"
            yield "    }"

    def _start(self) -> Iterator[str]:
        n_wires = len(self.fused.system.wires)
        n_passes = n_wires + 1 + self.fused.schedule.initial_passes
        yield "bool system_start(Memory *memory, const double *values, double t0) {"
        yield f"    Sent sent[{max(n_wires, 1)}] = {{{{0.0, false}}}};"
        yield "    bool has_moved = true;"
        yield "    (void)sent;"
        yield "    system_attach(memory);"
        yield "    memory->tick = 0;"
        yield "    memory->t0 = t0;"
        yield "    memset(memory->passes, 0, sizeof memory->passes);"
        if self.fused.scenario.events:
            yield from self.events.start()
        for inner in self.inners:
            yield f"    {inner.model.prefix}instance_reset(&memory->{inner.member});"
            if not inner.model.is_foreign:
                yield f"    memory->{inner.member}.cut.h = NAN; /* no step is as long as this one */"
        yield "    system_take_parameters(memory, values);"
        yield "    system_take_inputs(memory, values);"
        yield "    take_states(memory, values);"
        for inner in self.inners:
            call = f'{inner.model.prefix}enter_initialisation(&memory->{inner.member}, "initialisation", t0)'
            yield f"    if (!{call}) {{"
            yield "        return false;"
            yield "    }"
        yield f"    for (int i = 0; i < {n_passes} && has_moved; i++) {{"
        yield "        has_moved = false;"
        for name in self.fused.schedule.order:
            if self.fused.system.wires_into(name):
                yield f"        if (!pull_{self.fused.inners[name].member}(memory, sent, &has_moved)) {{"
                yield "            return false;"
                yield "        }"
        yield "    }"
        yield "    if (has_moved) {"
        yield "        return refuse_unsettled(memory);"
        yield "    }"
        for inner in self.inners:
            call = f'{inner.model.prefix}exit_initialisation(&memory->{inner.member}, "initialisation")'
            yield f"    if (!{call}) {{"
            yield "        return false;"
            yield "    }"
        yield "    fill_values(memory);"
        yield "    return true;"
        yield "}"
