"""A system that is ready to step: what was read, joined, ordered and checked."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from master.coupling.algebraic import algebraic_loops
from master.coupling.ledger import Ledger, input_entry, make_ledger
from master.coupling.schedule import Schedule
from master.fmi.values import alias_notes, start_notes
from master.recording.selection import Selection
from master.system.config import Compare, Config, PhaseLead
from master.system.graph import System
from master.system.grid import Grid
from master.system.inputs import MeasuredInputs
from master.system.scenario import Scenario
from master.text.signal_name import SignalName

DIVERGENCE_FACTOR = 100.0
_MOST_NOTES = 20  # about the start values of one FMU


@dataclass(frozen=True)
class Experiment:
    """
    A checked system, ready to run.

    `config` is what was read, for writing the system again; all that a run or an analysis needs of it has a
    name here. `overridden` are the signals that a variant or `--set` gave a value; `remarks` say how the
    file was read; `is_designed` if the values of a phase lead are those of an earlier design;
    `selection` is what goes to the result files, `plots` the signals of each plot that the file asks for.
    """

    config: Config
    variant: str | None
    system: System
    schedule: Schedule
    scenario: Scenario = field(default_factory=Scenario)
    overridden: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
    is_designed: bool = False
    inputs: MeasuredInputs = field(default_factory=MeasuredInputs)
    selection: Selection = field(default_factory=Selection)
    plots: tuple[tuple[str, ...], ...] = ()

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.config.name

    @property
    def title(self) -> str:
        """Name of the system, with that of the variant."""
        return " / ".join(filter(None, (self.name, self.variant)))

    @property
    def n_variants(self) -> int:
        """Number of variants that the file has."""
        return len(self.config.variants)

    @property
    def compare(self) -> Compare | None:
        """Signals that a run is judged by."""
        return self.config.compare

    @property
    def compare_in_fmus(self) -> Compare | None:
        """Those signals, outputs of the whole system as the FMU's outputs that they come from."""
        compare = self.config.compare
        if compare is None:
            return None
        source = {w.target.name: w.source.name for w in self.system.outlets}
        named = {key: SignalName(source[v]) for key, v in compare.model_dump().items() if v in source}
        return compare.model_copy(update=named)

    @property
    def draws(self) -> bool:
        """Whether a run makes a picture: always, unless the file has `plots: []`."""
        return self.config.plots != []

    @property
    def phase_lead(self) -> PhaseLead | None:
        """Phase lead that is to be designed before a run."""
        return self.config.dpdc

    @property
    def duration(self) -> float:
        """Time from start to stop [s]."""
        return self.config.stop_time - self.config.start_time

    @property
    def grid(self) -> Grid:
        """Time grid of the run."""
        return Grid(self.config.start_time, self.config.step_size, self.config.n_ticks)

    @property
    def ledger(self) -> Ledger:
        """Delays of all connections and loops."""
        ledger = make_ledger(self.system, self.schedule, self.config.step_size)
        fed = [
            input_entry(self.system, feed.source, feed.target, feed.age, self.config.step_size)
            for feed in self.inputs.feeds
        ]
        return replace(ledger, entries=(*ledger.entries, *fed))

    @property
    def notes(self) -> list[str]:
        """
        What a user should know before a run.

        These are how the file was read, the algebraic loops that the order does not solve, FMUs that never
        step, and what breaks the FMUs' own rules: start values, and units of aliases.
        """
        loops = algebraic_loops(self.system, self.schedule)
        notes = [*self.remarks]
        notes += [f"algebraic loop {loop.explain()}" for loop in loops if not loop.is_solved]
        for name, instance in self.system.instances.items():
            interval = self.schedule.every[name]
            if interval > self.grid.n_ticks:
                run = f"a run of {self.grid.n_ticks}"
                notes.append(f"{name} is never stepped, got a step every {interval} ticks in {run}")
            found = [*start_notes(instance.description, instance.start), *alias_notes(instance.description)]
            notes += [f"{name}.{note}" for note in found[:_MOST_NOTES]]
            if len(found) > _MOST_NOTES:
                notes.append(f"{name}: {len(found) - _MOST_NOTES} more notes of this kind")
        return notes

    @property
    def limits(self) -> dict[str, float]:
        """Magnitudes beyond which the run has diverged; compared motions: 100 times the offset."""
        compare = self.compare
        found: dict[str, float] = {}
        if compare is not None:
            signals = [s for s in (compare.signal, compare.reproduced) if s is not None]
            found = dict.fromkeys(signals, DIVERGENCE_FACTOR * compare.offset)
        return found | self.config.limits

    @property
    def compared(self) -> tuple[str, ...]:
        """Signals that the run is judged by."""
        compare = self.config.compare
        return (
            () if compare is None else tuple(v for v in compare.model_dump().values() if isinstance(v, str))
        )
