"""From a YAML file to a system that is ready to step: variant, overrides, FMU files, graph, schedule."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from master.coupling.algebraic import algebraic_loops
from master.coupling.ledger import Ledger, input_entry, make_ledger
from master.coupling.schedule import Schedule
from master.system.config import Config
from master.system.graph import System
from master.system.grid import Grid
from master.system.inputs import MeasuredInputs
from master.system.scenario import Scenario

DIVERGENCE_FACTOR = 100.0


@dataclass(frozen=True)
class Experiment:
    """A checked system, ready to run."""

    config: Config
    variant: str | None
    system: System
    schedule: Schedule
    scenario: Scenario = field(default_factory=Scenario)
    inputs: MeasuredInputs = field(default_factory=MeasuredInputs)

    @property
    def grid(self) -> Grid:
        """Time grid of the run."""
        return Grid(self.config.start_time, self.config.step_size, self.config.n_ticks)

    @property
    def ledger(self) -> Ledger:
        """Delays of all connections and loops."""
        ledger = make_ledger(self.system, self.schedule, self.config.step_size)
        fed = [input_entry(self.system, f.source, f.target, self.config.step_size) for f in self.inputs.feeds]
        return replace(ledger, entries=(*ledger.entries, *fed))

    @property
    def notes(self) -> list[str]:
        """What a user should know before a run: the algebraic loops that the order does not solve."""
        found = algebraic_loops(self.system, self.schedule)
        return [f"algebraic loop {loop.explain()}" for loop in found if not loop.is_solved]

    @property
    def limits(self) -> dict[str, float]:
        """Magnitudes beyond which the run has diverged; compared motions: 100 times the offset."""
        compare = self.config.compare
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
