"""What a failed execution was about, as an error that names the FMU, the call, the time and the reason."""

from __future__ import annotations

from collections.abc import Mapping

from master.errors import FmuError
from master.fmi.native.cells import first_misfit
from master.fmi.slave import Slave
from master.fmi.status import Status, described, status_name
from master.fmi.value_types import NAMES, RANGES

from .machine.fmu_step import Call
from .machine.interpreter import Execution, Stop
from .machine.operations import MOST_RETURNS, Deviation
from .machine.program import Program

_CALLS = {
    Call.SET: "the setter of its inputs",
    Call.STEP: "the step",
    Call.GET: "the getter of its outputs",
    Call.SAVE: "the getter of its state",
    Call.RESTORE: "the setter of its state",
}
_DEVIATIONS = {
    Deviation.STOOD_STILL: "returned early from a step without getting on, expected the step's end",
    Deviation.WANTED_EVENTS: "asks for event mode, which it was not given, expected that it handles its "
    "events itself",
    Deviation.TOO_MANY_RETURNS: f"returned early from a step again and again, got more than {MOST_RETURNS} "
    "returns, expected the step's end",
    Deviation.NO_STATE: "the getter of its state gave none, expected a state to go back to",
    Deviation.NO_TIME: "the last successful time of a step is not a number, got nan, expected a time within "
    "the step",
}


def failure_of(program: Program, slaves: Mapping[str, Slave], ended: Execution, time: float) -> FmuError:
    """Return the error of an execution that stopped in the tick that begins at `time` [s]."""
    if ended.stop == Stop.NOT_CONVERGED:
        return _not_converged(program, ended.where, time)
    instance = program.instance_of(ended.where)
    said = slaves[instance].last_message()
    fault = slaves[instance].process_fault()
    if fault:
        return FmuError(instance, fault, time=time, status="fatal")
    if ended.status == Deviation.MISFIT:
        text = _misfit(program, ended.where)
    elif ended.status in _DEVIATIONS:
        text = _DEVIATIONS[Deviation(ended.status)]
    else:
        text = _answered(ended, said)
    name = "error" if ended.status in list(Deviation) else status_name(ended.status)
    return FmuError(instance, text, time=time, status=name)


def _answered(ended: Execution, said: str) -> str:
    """What an FMU said, and its status; an error that it explains needs no more words."""
    call = _CALLS[Call(ended.call)]
    if said and ended.status == Status.ERROR and ended.call == Call.STEP:
        return said
    answer = f"{call} answered with {described(ended.status)}"
    return f"{said} ({answer})" if said else answer


def _misfit(program: Program, operation: int) -> str:
    """Name the first value that the type of its input does not hold."""
    values = program.values
    for block in program.blocks_to_set(operation):
        misfit = first_misfit(values[block.place :].ctypes.data, block.n_values, block.value_type)
        if misfit >= 0:
            break
    place = block.place + misfit
    least, largest = RANGES[block.value_type]
    return (
        f"{program.signal_at(place)}: value does not fit {NAMES[block.value_type]}, got {values[place]:g}, "
        f"expected from {least:g} to {largest:g}"
    )


def _not_converged(program: Program, row: int, time: float) -> FmuError:
    memory = program.memory
    source, target, c = memory.residuals[row]
    sent = memory.conversions[c, 0] * memory.values[source] + memory.conversions[c, 1]
    residual = abs(sent - memory.values[target])
    wire = program.loop_wires[row]
    message = (
        f"the iteration over {wire} does not converge, got a residual of {residual:.3g}, "
        f"expected at most {memory.tolerances[row]:.3g}"
    )
    return FmuError(wire.partition(".")[0], message, time=time)
