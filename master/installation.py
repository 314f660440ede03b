"""What this installation has: configurations by name, caches, and packages that only some work needs."""

from __future__ import annotations

import importlib.util
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fmu_sources.export.places import (
    CONFIG_FOLDER,
    IS_CHECKOUT,
    SHIPPED,
    cache_folder,
    can_be_written,
    install_command,
    wanted_cache_folder,
)

from .errors import ConfigError, Problem, closest, readable

__all__ = [
    "CAMPAIGN",
    "CONFIG_FOLDER",
    "EXTRAS",
    "IS_CHECKOUT",
    "NATIVE",
    "NOTEBOOK",
    "SHIPPED",
    "Extra",
    "cache_folder",
    "can_be_written",
    "configuration",
    "install_command",
    "is_installed",
    "require",
    "require_native",
    "shipped_configuration",
    "shipped_configurations",
    "wanted_cache_folder",
]


def shipped_configurations() -> dict[str, Path]:
    """Map names of the configurations that are shipped to their files: `hexapod/drag`, `measured/emps`."""
    found = sorted(CONFIG_FOLDER.rglob("*.yaml"))
    return {path.relative_to(CONFIG_FOLDER).with_suffix("").as_posix(): path for path in found}


def configuration(given: str | Path) -> Path:
    """
    Find a system or a case: a file as it is, else a configuration that is shipped, by its name.

    Raises:
        ConfigError: If it is neither; a path with an ending is left to who reads it.
    """
    path = Path(given)
    return path if path.suffix or path.is_file() else shipped_configuration(path.as_posix())


def shipped_configuration(name: str) -> Path:
    """
    Find a configuration that is shipped; a case of `measured/` also without the folder.

    Raises:
        ConfigError: If there is none of that name.
    """
    shipped = shipped_configurations()
    plain = name.removesuffix(".yaml")
    for known in (plain, f"measured/{plain}"):
        if known in shipped:
            return shipped[known]
    near = closest(plain, [*shipped, *(known.rpartition("/")[2] for known in shipped)])
    wanted = f"a name that `dockloop examples` lists{f', as {near}' if near else ''}, or a file"
    problem = Problem("no such file and no shipped configuration", where=readable(name), expected=wanted)
    raise ConfigError([problem])


@dataclass(frozen=True)
class Extra:
    """A group of optional packages: its name for pip, the modules it brings, and what they are for."""

    name: str
    modules: tuple[str, ...]
    purpose: str

    @property
    def missing(self) -> list[str]:
        """Modules that are not installed."""
        return [module for module in self.modules if not is_installed(module)]


NATIVE = Extra(
    "native", ("casadi", "ziglang"), "native FMUs from sources: build, diagnose, models with effects"
)
NOTEBOOK = Extra(
    "notebook", ("pandas", "xarray"), "results as a DataFrame or a Dataset: to_pandas, to_xarray"
)
DATA = Extra("data", ("asammdf", "h5py", "nptdms", "rosbags"), "recordings in MDF, HDF5, TDMS and ROS bags")
CAMPAIGN = Extra("campaign", ("dask", "distributed"), "campaigns on a cluster: dockloop sweep --scheduler")
EXTRAS = (NATIVE, NOTEBOOK, DATA, CAMPAIGN)


def is_installed(module: str) -> bool:
    """Whether a module can be imported; it is not."""
    return importlib.util.find_spec(module) is not None


def require(extra: Extra, what: str, modules: Sequence[str] | None = None) -> None:
    """
    Check that some work has the packages it needs.

    Args:
        extra: The group that brings them.
        what: The work, as the message names it.
        modules: Those that are needed; all of the extra by default.

    Raises:
        ConfigError: With what is missing and the command that installs it.
    """
    missing = [module for module in modules or extra.modules if module in extra.missing]
    if missing:
        got = f"no {' and no '.join(missing)}"
        raise ConfigError(
            [Problem("not installed", where=what, got=got, expected=install_command(extra.name))]
        )


def require_native(what: str) -> None:
    """
    Check that native FMUs can be built here: CasADi for their C code, a C compiler or zig for the library.

    Raises:
        ConfigError: With what is missing and the command that installs it.
    """
    require(NATIVE, what, ("casadi",) if shutil.which("cc") else NATIVE.modules)
