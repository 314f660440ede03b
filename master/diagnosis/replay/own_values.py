"""Parameters that each recording has for itself: `fmu.name@recording` in a fit, `fmu.name` in its replays."""

from __future__ import annotations

from collections.abc import Mapping

from master.diagnosis.case.cut import Values
from master.text.signal_name import SignalName

AT = "@"


def own_name(key: str, recording: str) -> str:
    """Name of the parameter `fmu.name` of one recording in a fit."""
    return f"{key}{AT}{recording}"


def of_recording(values: Values, recording: str, given: Mapping[str, float]) -> Values:
    """
    Values that hold in one recording of a case.

    Args:
        values: FMU to values; those called `name@recording` hold in that recording alone.
        recording: Its name.
        given: Values `fmu.name` that the case sets for it.
    """
    if not given and not any(AT in name for own in values.values() for name in own):
        return values
    result: Values = {}
    for fmu, own in values.items():
        plain = {name: value for name, value in own.items() if AT not in name}
        plain |= {
            name.partition(AT)[0]: value for name, value in own.items() if name.partition(AT)[2] == recording
        }
        result[fmu] = plain
    for key, value in given.items():
        name = SignalName(key)
        if name.instance in result:
            result[name.instance][name.variable] = value
    return result


def not_fitted(values: Values, keys: Mapping[str, object], recording: str) -> list[str]:
    """Parameters of which other recordings have values of their own, and this one has none."""
    missing = []
    for key in keys:
        name = SignalName(key)
        own = values.get(name.instance, {})
        fitted = [other.partition(AT)[2] for other in own if other.startswith(f"{name.variable}{AT}")]
        if fitted and recording not in fitted:
            missing.append(key)
    return missing
