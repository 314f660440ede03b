"""Systems of stubs: joined as a YAML file would, scheduled and run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from master.coupling.ledger import Ledger, make_ledger
from master.coupling.schedule import Schedule, make_schedule
from master.fmi.description import Description
from master.stepping.outcome import Outcome, RunOptions
from master.stepping.simulate import simulate
from master.system.config import Config, LoadedConfig
from master.system.graph import System, build_system
from master.system.grid import Grid
from master.text.yaml_lines import Document

from .slave import Block, Stub


def wire(source: str, target: str, **more: Any) -> dict[str, Any]:
    """A connection as in the YAML form."""
    return {"from": source, "to": target, **more}


@dataclass
class Bench:
    """A system of stubs, scheduled, and the slaves of its latest run."""

    blocks: Mapping[str, Block]
    loaded: LoadedConfig
    system: System
    schedule: Schedule
    slaves: dict[str, Stub] = field(default_factory=dict)

    @property
    def step_size(self) -> float:
        """Step size [s]."""
        return self.loaded.config.step_size

    @property
    def ledger(self) -> Ledger:
        """Its delays."""
        return make_ledger(self.system, self.schedule, self.step_size)

    def factory(self, name: str, description: Description) -> Stub:
        """Make one slave."""
        self.slaves[name] = Stub(name, description, self.blocks[name].law)
        return self.slaves[name]

    def run(self, n_ticks: int, *, t0: float = 0.0, compiled: bool = False, **more: Any) -> Outcome:
        """Step it; `limits`, `scenario`, `pacer` and `sink` are those of RunOptions."""
        self.slaves.clear()
        options = RunOptions(**{f.name: more.pop(f.name) for f in fields(RunOptions) if f.name in more})
        return simulate(
            self.system,
            self.schedule,
            Grid(t0, self.step_size, n_ticks),
            options=options,
            factory=self.factory,
            compiled=compiled,
            **more,
        )


def bench(
    blocks: Mapping[str, Block],
    connections: Sequence[Mapping[str, Any]] = (),
    order: Sequence[str | list[str] | dict[str, Any]] | None = None,
    *,
    step_size: float = 1.0,
    every: Mapping[str, int] | None = None,
    start: Mapping[str, Mapping[str, float]] | None = None,
) -> Bench:
    """Join blocks as a YAML file would; steps of 1 s, so that times are row numbers."""
    every, start = every or {}, start or {}
    fmus = {n: {"source": n, "every": every.get(n, 1), "start": dict(start.get(n, {}))} for n in blocks}
    data = {
        "name": "bench",
        "step_size": step_size,
        "stop_time": step_size,
        "fmus": fmus,
        "connections": list(connections),
        "coupling": {"order": order},
    }
    loaded = LoadedConfig(config=Config.model_validate(data), document=Document(Path("bench.yaml"), data))
    descriptions = {name: block.description(name) for name, block in blocks.items()}
    system = build_system(loaded, descriptions, {})
    schedule = make_schedule(system, loaded.config.coupling.order, "coupling.order")
    return Bench(blocks, loaded, system, schedule)
