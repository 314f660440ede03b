"""
Systems of FMUs from Python: load, run, sweep, step, analyse, diagnose.

    import dockloop as dl

    system = dl.load("low_frequency")            # a shipped configuration, a YAML file, an SSP, a dict
    run = system.run(variant="none", set={"spacecraft.m_s": 500})
    run["spacecraft.s_des"]                      # shape (rows,), unit run.unit("spacecraft.s_des")

The functions are those of the command `dockloop`. Nothing prints; faults are exceptions, and `ConfigError`
carries all `problems`. Values are in the units of the variables, times in seconds. Objects of different
systems may be used side by side; any thread may call, one at a time is inside an FMU.

A name of this package is loaded when it is first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from master.errors import ConfigError, DataError, FmuError, MasterError, Problem
    from master.runs.differences import Comparison

    from .campaign import Campaign, sweep
    from .compared import compare
    from .fmu import Fmu, open_fmu, to_fmu
    from .measured import Diagnosis, diagnose
    from .python_block import Block, block
    from .result import Run
    from .simulation import SavedState, Simulation
    from .system import System, analyse, configurations, load, write_ssp

_HOMES = {
    "Block": ".python_block",
    "Campaign": ".campaign",
    "Comparison": "master.runs.differences",
    "ConfigError": "master.errors",
    "DataError": "master.errors",
    "Diagnosis": ".measured",
    "Fmu": ".fmu",
    "FmuError": "master.errors",
    "MasterError": "master.errors",
    "Problem": "master.errors",
    "Run": ".result",
    "SavedState": ".simulation",
    "Simulation": ".simulation",
    "System": ".system",
    "analyse": ".system",
    "block": ".python_block",
    "compare": ".compared",
    "configurations": ".system",
    "diagnose": ".measured",
    "load": ".system",
    "open_fmu": ".fmu",
    "sweep": ".campaign",
    "to_fmu": ".fmu",
    "write_ssp": ".system",
}

__all__ = [  # noqa: RUF022  # in the order in which they are used
    "load",
    "System",
    "Run",
    "Simulation",
    "SavedState",
    "block",
    "Block",
    "open_fmu",
    "Fmu",
    "to_fmu",
    "analyse",
    "compare",
    "Comparison",
    "sweep",
    "Campaign",
    "diagnose",
    "Diagnosis",
    "write_ssp",
    "configurations",
    "MasterError",
    "ConfigError",
    "DataError",
    "FmuError",
    "Problem",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("dockloop")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(_HOMES[name], __name__), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
