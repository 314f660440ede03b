"""From a YAML file to a system that is ready to step: variant, overrides, FMU files, graph, schedule."""

from __future__ import annotations

from dataclasses import dataclass, field

from master.coupling.algebraic import algebraic_loops
from master.coupling.ledger import Ledger, make_ledger
from master.coupling.schedule import Schedule
from master.fmi.values import start_notes
from master.system.config import Config
from master.system.graph import System
from master.system.grid import Grid
from master.system.scenario import Scenario

DIVERGENCE_FACTOR = 100.0
_MOST_NOTES = 20  # about the start values of one FMU


@dataclass(frozen=True)
class Experiment:
    """A checked system, ready to run."""

    config: Config
    variant: str | None
    system: System
    schedule: Schedule
    scenario: Scenario = field(default_factory=Scenario)

    @property
    def grid(self) -> Grid:
        """Time grid of the run."""
        return Grid(self.config.start_time, self.config.step_size, self.config.n_ticks)

    @property
    def ledger(self) -> Ledger:
        """Delays of all connections and loops."""
        return make_ledger(self.system, self.schedule, self.config.step_size)

    @property
    def notes(self) -> list[str]:
        """
        What a user should know before a run.

        These are the algebraic loops that the order does not solve, and start values of the FMUs themselves
        that break their own rules.
        """
        loops = algebraic_loops(self.system, self.schedule)
        notes = [f"algebraic loop {loop.explain()}" for loop in loops if not loop.is_solved]
        for name, instance in self.system.instances.items():
            found = start_notes(instance.description, instance.start)
            notes += [f"{name}.{note}" for note in found[:_MOST_NOTES]]
            if len(found) > _MOST_NOTES:
                notes.append(f"{name}: {len(found) - _MOST_NOTES} more start values of this kind")
        return notes

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
