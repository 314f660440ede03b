"""An SSP 1.0 archive as a configuration; one that is not ours is stepped side by side, as SSP tools do."""

from __future__ import annotations

import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from master.errors import ConfigError
from master.system.config import Config, LoadedConfig
from master.text.validation import validated
from master.text.yaml_lines import Document

from .names import COUPLING, STRUCTURE, ssc, ssd, ssv

_DEFAULT_STEP = 1e-3


def read_ssp(path: Path, folder: Path) -> LoadedConfig:
    """
    Unpack an archive into a folder and read its system.

    Raises:
        ConfigError: If the file is not an SSP archive or its system is not a flat one of FMUs.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)
        root = ET.parse(folder / STRUCTURE).getroot()
    except FileNotFoundError:
        raise ConfigError(
            [f"{path}: no such file or no {STRUCTURE} in it, expected an SSP archive"]
        ) from None
    except (zipfile.BadZipFile, ET.ParseError, OSError):
        raise ConfigError([f"{path}: not an SSP archive, expected a zip file with {STRUCTURE}"]) from None
    system = root.find(ssd("System"))
    if system is None:
        raise ConfigError([f"{path}: {STRUCTURE} has no System"])
    data = _configuration(root, system, folder)
    document = Document(folder / path.name, data)
    return LoadedConfig(validated(Config, replace(document, path=path), "system"), document)


def _configuration(root: ET.Element, system: ET.Element, folder: Path) -> dict[str, Any]:
    experiment = root.find(ssd("DefaultExperiment"))
    times = {} if experiment is None else experiment.attrib
    extra = _coupling(system)
    every = extra.pop("every", {})
    extra.pop("variant", None)
    fmus = {
        c.get("name", ""): _fmu(c, folder, every)
        for c in system.iterfind(f"{ssd('Elements')}/{ssd('Component')}")
    }
    found: dict[str, Any] = {
        "name": root.get("name") or "system",
        "step_size": _DEFAULT_STEP,
        "start_time": float(times.get("startTime", 0.0)),
        "stop_time": float(times.get("stopTime", 1.0)),
        "fmus": fmus,
        "coupling": {"order": [list(fmus)]},
        "connections": [_connection(c) for c in system.iterfind(f"{ssd('Connections')}/{ssd('Connection')}")],
    }
    return found | extra


def _coupling(system: ET.Element) -> dict[str, Any]:
    for annotation in system.iterfind(f"{ssd('Annotations')}/{ssc('Annotation')}"):
        if annotation.get("type") == COUPLING:
            found = annotation.find("Coupling")
            data = json.loads((found.text if found is not None else None) or "{}")
            return dict(data) if isinstance(data, dict) else {}
    return {}


def _fmu(component: ET.Element, folder: Path, every: dict[str, int]) -> dict[str, Any]:
    name, source = component.get("name", ""), component.get("source", "")
    values: dict[str, Any] = {}
    for binding in component.iterfind(f"{ssd('ParameterBindings')}/{ssd('ParameterBinding')}"):
        inline = binding.find(f"{ssd('ParameterValues')}/{ssv('ParameterSet')}")
        parameters = inline if inline is not None else ET.parse(folder / binding.get("source", "")).getroot()
        values |= _values(parameters)
    return {"source": source, "start": values, "every": every.get(name, 1)}


def _values(parameter_set: ET.Element) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for parameter in parameter_set.iterfind(f"{ssv('Parameters')}/{ssv('Parameter')}"):
        for value in parameter:
            kind, text = value.tag.rpartition("}")[2], value.get("value", "")
            found[parameter.get("name", "")] = _value(kind, text)
    return found


def _value(kind: str, text: str) -> bool | int | float | str:
    if kind == "Real":
        return float(text)
    if kind == "Integer":
        return int(text)
    return text == "true" if kind == "Boolean" else text


def _connection(c: ET.Element) -> dict[str, Any]:
    return {
        "from": f"{c.get('startElement')}.{c.get('startConnector')}",
        "to": f"{c.get('endElement')}.{c.get('endConnector')}",
    }
