"""Run in an environment with libcosimpy: an FMU and an experiment (JSON) in, rows of outputs (JSON) out."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def main(fmu: str, experiment: str) -> None:
    log_output_level(CosimLogLevel.ERROR)
    given = json.loads(Path(experiment).read_text())
    execution = CosimExecution.from_step_size(round(given["step"] * 1e9))  # ns
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="fmu"))
    variables = {v.name.decode(): v for v in execution.slave_variables(slave)}
    starts = {**given["parameters"], **dict(zip(given["inputs"], given["rows"][0], strict=True))}
    setters = {
        CosimVariableType.REAL: execution.real_initial_value,
        CosimVariableType.INTEGER: execution.integer_initial_value,
        CosimVariableType.BOOLEAN: execution.boolean_initial_value,
    }
    for name, value in starts.items():
        v = variables[name]
        assert setters[CosimVariableType(v.type)](slave, v.reference, value), name
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator)
    assert execution.add_observer(observer)
    inputs, outputs = ([variables[n].reference for n in given[kind]] for kind in ("inputs", "outputs"))
    rows = []
    for row in given["rows"][:-1]:
        assert manipulator.slave_real_values(slave, inputs, row)
        assert execution.step()
        rows.append(list(observer.last_real_values(slave, outputs)))
    sys.stdout.write(json.dumps(rows))


if __name__ == "__main__":
    main(*sys.argv[1:])
