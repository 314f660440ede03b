"""libcosim through libcosimpy: fixed step, FMUs side by side; an observer keeps the last values."""

from __future__ import annotations

import json
import sys
from importlib.metadata import version
from pathlib import Path

from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave
from measure import answer, timed


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    log_output_level(CosimLogLevel.ERROR)
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    execution = CosimExecution.from_step_size(round(spec["step_size"] * 1e9))  # ns
    slaves, variables = {}, {}
    setters = {
        CosimVariableType.REAL: execution.real_initial_value,
        CosimVariableType.INTEGER: execution.integer_initial_value,
        CosimVariableType.BOOLEAN: execution.boolean_initial_value,
    }
    for name, given in spec["fmus"].items():
        slave = CosimLocalSlave(fmu_path=given["path"], instance_name=name)
        slaves[name] = execution.add_local_slave(slave)
        variables[name] = {v.name.decode(): v for v in execution.slave_variables(slaves[name])}
        for variable, value in given["start"].items():
            v = variables[name][variable]
            assert setters[CosimVariableType(v.type)](slaves[name], v.reference, value), variable
    for wire in spec["connections"]:
        ends = []
        for name, variable in (signal.split(".", 1) for signal in wire):
            ends += [slaves[name], variables[name][variable].reference]
        execution.connect_real_variables(*ends)
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    reals = {
        name: [v for v in given["outputs"] if given["kinds"][v] == "Real"]
        for name, given in spec["fmus"].items()
    }
    seconds = timed(lambda: execution.step(int(n_steps)))
    final = []
    for name, wanted in reals.items():
        references = [variables[name][v].reference for v in wanted]
        values = observer.last_real_values(slaves[name], references)
        final += [(f"{name}.{v}", x) for v, x in zip(wanted, values, strict=True)]
    answer(seconds, int(n_steps), version("libcosimpy"), final)


if __name__ == "__main__":
    main(*sys.argv[1:])
