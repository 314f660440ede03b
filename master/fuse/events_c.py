"""The events of a system as tables in C, which `c_events/play.c` plays as a run does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from master.errors import Problem
from master.system.scenario import Action, Scenario, ScenarioEvent
from master.text.signal_name import SignalName

from .foreign import ForeignModel
from .layout import Fused
from .program_c import number, quoted, written


class EventWriter:
    """Writes the C of the events of a system; `channel_of` numbers the channels, `place` the values."""

    def __init__(self, fused: Fused, channel_of: Mapping[str, int], place: Mapping[str, int]) -> None:
        self.fused = fused
        self.channel_of = channel_of
        self.place = place
        conditional = [e for e in fused.scenario.events if e.condition is not None]
        self.events = [*conditional, *(e for e in fused.scenario.events if e.condition is None)]

    def sizes(self) -> Iterator[str]:
        """Sizes that the memory of the system is made of."""
        yield f"#define N_EVENTS {len(self.events)}"
        yield f"#define N_ACTIONS {sum(len(event.actions) for event in self.events)}"
        yield f"#define N_CHANNELS {len(self.channel_of)}"

    def tables(self) -> Iterator[str]:
        """All events and what they do."""
        yield "const Action system_actions[N_ACTIONS] = {"
        for event in self.events:
            for action in event.actions:
                yield f"    {self._action(action)},"
        yield "};"
        yield ""
        yield "const Event system_events[N_EVENTS] = {"
        first = 0
        for event in self.events:
            yield f"    {self._event(event, first)},"
            first += len(event.actions)
        yield "};"
        yield ""
        yield "void apply_action(Memory *memory, int action) {"
        yield "    switch (action) {"
        yield from self._cases()
        yield "    default:"
        yield "        break;"
        yield "    }"
        yield "}"

    def start(self) -> Iterator[str]:
        """Statements that let nothing have begun."""
        fallbacks = []
        for name in self.channel_of:
            signal = SignalName(name)
            value = self.fused.system.instances[signal.instance].value_of(signal.variable)
            fallbacks.append(number(float(value or 0.0)))
        yield f"    const double fallbacks[] = {{{', '.join(fallbacks) or '0.0'}}};"
        yield "    play_from_the_start(memory, fallbacks);"
        yield f"    if (t0 != {number(self.fused.grid.t0)}) {{"
        what = "events: at times of the system, got a start at "
        yield f"        text_append(&memory->message, {quoted(what)});"
        yield "        text_append_number(&memory->message, t0);"
        yield f'        text_append(&memory->message, " s, expected {self.fused.grid.t0:.15g} s");'
        yield "        return false;"
        yield "    }"

    def _action(self, action: Action) -> str:
        if action.value is not None:
            return "{.sets = true}"
        changes = ", ".join(f"{{{column}, {number(float(n))}}}" for column, n in action.columns.items())
        return f"{{false, {self.channel_of[action.target]}, {len(action.columns)}, {{{changes}}}}}"

    def _event(self, event: ScenarioEvent, first: int) -> str:
        lasts = -1 if event.duration is None else self.fused.grid.ticks_of(event.duration)
        tick = -1 if event.at is None else self.fused.grid.tick_at(event.at)
        place = 0
        sign = 1.0
        threshold = 0.0
        if event.condition is not None:
            place = self.place[event.condition.signal]
            sign = event.condition.sign
            threshold = event.condition.threshold
        what = f"{tick}, {place}, {number(sign)}, {number(threshold)}, {lasts}"
        return f"{{{what}, {first}, {first + len(event.actions)}}}"

    def _cases(self) -> Iterator[str]:
        actions = [action for event in self.events for action in event.actions]
        for i, action in enumerate(actions):
            if action.value is None:
                continue
            signal = SignalName(action.target)
            inner = self.fused.inners[signal.instance]
            variable = inner.description.primary(signal.variable)
            own = f"memory->{inner.member}.now.values[{inner.model.place(variable)}]"
            yield f"    case {i}: /* {action.target} */"
            yield f"        {own} = {written(number(action.value), variable.value_type)};"
            yield "        break;"


def refused_events(scenario: Scenario, fused: Fused) -> Iterator[Problem]:
    """Say what events do that a system as one FMU cannot."""
    handed = {wire.target.name for wire in fused.system.inlets}
    for i, event in enumerate(scenario.events):
        where = f"events[{i}]"
        if event.condition is not None and not _is_kept(event.condition.signal, fused):
            yield Problem(
                "a condition on a signal that this FMU does not keep",
                where=where,
                got=event.condition.signal,
                expected="an output of an FMU that is shown",
            )
        for action in event.actions:
            if action.value is None:
                continue
            if action.target in handed or not _is_of_an_fmu(action.target, fused):
                yield Problem(
                    "an event that sets an input of the system itself",
                    where=where,
                    got=action.target,
                    expected="inputs of FMUs that nothing leads to, and their tunable parameters",
                )
            elif not _is_kept(action.target, fused):
                yield Problem(
                    "an event that sets a variable that this FMU does not show",
                    where=where,
                    got=action.target,
                    expected="scalars that the exported FMU has",
                )


def _is_of_an_fmu(signal: str, fused: Fused) -> bool:
    return SignalName(signal).instance in fused.inners


def _is_kept(name: str, fused: Fused) -> bool:
    """Whether a signal is among the values that are kept of its FMU here."""
    signal = SignalName(name)
    if signal.instance not in fused.inners:
        return False
    model = fused.inners[signal.instance].model
    return not isinstance(model, ForeignModel) or signal.variable in model.places
