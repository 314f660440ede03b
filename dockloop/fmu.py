"""Single FMUs: what they are, stepped by hand, and made from models."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from fmu_sources.export.own_model import OwnModelError, load_model, own_fmu
from fmu_sources.export.whole_file import write_whole
from fmu_sources.framework.model import Model
from master import catalogue
from master.errors import ConfigError, Problem
from master.fmi.description_reader import read_description
from master.fmi.inspection import Inspection, inspect_fmu
from master.installation import require_native
from master.recording.folder import reason

from .simulation import Simulation
from .system import load

_NAME = "fmu"


def open_fmu(source: str | Path, *, flavour: str = "native") -> Fmu:
    """
    Read what an FMU says of itself; none of its code is run.

    Args:
        source: Path of an FMU 2.0 or 3.0 for co-simulation, or the name of a model (`compensator`).
        flavour: Which FMU a model's name means: `native` (FMI 2.0), `fmi3`, or `python`.

    Raises:
        ConfigError: If there is none, or it cannot be read; with all that is wrong in it.
    """
    target = catalogue.locate(str(source), Path(), flavour)
    file = catalogue.files({_NAME: target}, catalogue.silent)[_NAME]
    return Fmu(inspect_fmu(read_description(file)))


class Fmu:
    """
    An FMU: its variables, what it can do, what is odd about it; made by `open_fmu`.

    Attributes:
        path: Its file.
        variables: Each with `name`, `causality`, `variability`, `type`, `unit`, `start`, `minimum`,
            `maximum`, `items` (of an enumeration, name to number) and `description`.
        capabilities: Name to yes or no, and `fmi_version`.
        platforms: Folders of its binaries.
        odd: What a user should know.
    """

    def __init__(self, inspection: Inspection) -> None:
        self._inspection = inspection
        self.path = inspection.path
        self.name = inspection.name
        self.variables = inspection.variables
        self.capabilities = inspection.capabilities
        self.platforms = inspection.platforms
        self.odd = inspection.odd

    def units(self, causality: str | None = None) -> dict[str, str]:
        """Map variables, of one causality or all, to their units."""
        return {v.name: v.unit for v in self.variables if causality in (None, v.causality)}

    def open(
        self,
        start: Mapping[str, Any] | None = None,
        *,
        step_size: float = 1e-3,
        stop_time: float = 1e6,
        start_time: float = 0.0,
    ) -> Simulation:
        """
        Load it alone, to step by hand: `sim.set("fmu.u", 1.0)`, `sim.step()`, `sim["fmu.y"]`.

        Args:
            start: Parameters, start values and inputs by their names.
            step_size: Length of a step [s].
            stop_time: Time that it cannot step beyond [s].
            start_time: Time at the start [s].

        Raises:
            ConfigError: With each value that is wrong.
            FmuError: If it cannot be loaded or initialised.
        """
        ticks = round((stop_time - start_time) / step_size)
        content = {
            "name": self.name,
            "step_size": step_size,
            "start_time": start_time,
            "stop_time": start_time + ticks * step_size,
            "fmus": {_NAME: {"source": str(self.path.absolute()), "start": dict(start or {})}},
        }
        return load(content).open()

    def as_dict(self) -> dict[str, Any]:
        """All of it, as `dockloop inspect --json` prints it."""
        return self._inspection.as_dict()

    def __repr__(self) -> str:
        counts = {c: len(self.units(c)) for c in ("input", "output", "parameter")}
        said = ", ".join(f"{n} {c}s" for c, n in counts.items())
        return f"<Fmu {self.name}, FMI {self.capabilities['fmi_version']}: {said}>"

    def _repr_html_(self) -> str:
        head = (
            "<tr><th>name</th><th>causality</th><th>type</th><th>unit</th><th>start</th><th>meaning</th></tr>"
        )
        rows = "".join(
            "<tr>"
            + "".join(
                f"<td>{escape(str(cell))}</td>"
                for cell in (v.name, v.causality, v.type, v.unit, v.start, v.description)
            )
            + "</tr>"
            for v in self.variables
        )
        odd = "".join(f"<li>{escape(text)}</li>" for text in self.odd)
        return f"<b>{escape(repr(self)[1:-1])}</b><ul>{odd}</ul><table>{head}{rows}</table>"


def to_fmu(model: Model | str | Path, path: str | Path | None = None, *, flavour: str = "native") -> Path:
    """
    Export a model as an FMU for this machine that needs no Python.

    Args:
        model: A `fmu_sources.framework.model.Model`, or the path of a Python file that has one as `MODEL`.
        path: The file to write; `<name>.fmu` in the working folder by default.
        flavour: `native` (FMI 2.0) or `fmi3` (FMI 3.0).

    Raises:
        ConfigError: If declarations and equations do not agree, with the line that fails, if a tool is
            missing, or for anything else than a model: a block is a Python function, which an FMU without
            Python cannot hold.
    """
    if not isinstance(model, Model | str | Path):
        wanted = "a model of equations (fmu_sources/README.md) or the path of its Python file"
        raise ConfigError([Problem("not a model", where="to_fmu", got=repr(model), expected=wanted)])
    from fmu_sources.export.native import NativeBuildError

    require_native("to_fmu")
    file = None if isinstance(model, Model) else Path(model)
    try:
        loaded = model if isinstance(model, Model) else load_model(Path(model))
        content = own_fmu(loaded, flavour, file)
    except (OwnModelError, NativeBuildError) as error:
        raise ConfigError(str(error).splitlines()) from None
    target = Path(f"{loaded.name}.fmu") if path is None else Path(path)
    try:
        write_whole(target, content)
    except OSError as error:
        raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(target))]) from None
    return target
