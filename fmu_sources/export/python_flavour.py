"""The Python flavour: a model as an FMI 2.0 FMU that runs in the host's Python through PythonFMU."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pythonfmu

from ..composed.registry import ROOT, source_files
from ..framework.model import Model
from ..framework.starts import with_starts
from .archive import pack
from .facts import Flavour, guid
from .fmi2_xml import describe_fmi2

PYTHON = Flavour("Python flavour", needs_execution_tool=True)

_BINARIES = {"linux64": ".so", "win64": ".dll"}

_DEPENDENCIES = """\
This FMU runs inside the host's Python interpreter (3.11 or newer); it cannot be loaded by a host
without one. It needs no package beside the interpreter. Use the native flavour elsewhere.
"""

_COMPOSING = """
from {package}.composed.names import composed

MODEL = composed("{name}", lambda _, base=MODEL: base)"""

_STARTING = """
from {package}.framework.starts import with_starts

MODEL = with_starts(MODEL, {starts!r})"""

_SLAVE = '''\
"""Entry module of this FMU."""

import ctypes

from {package}.export.python_slave import ModelSlave
from {package}.{module} import MODEL{composing}

# PythonFMU runs this text at every instantiation and then gives back a reference to this namespace
# that it does not own; without one more, the interpreter frees the namespace while it is in use.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class Slave(ModelSlave):
    """FMI slave of the model."""

    model = MODEL
'''


def python_sources(model_file: Path, *more: Path) -> dict[str, bytes]:
    """Collect the modules that the FMU carries: path in the package to bytes."""
    shell = ROOT / "export" / "python_slave.py"
    files = {ROOT / "__init__.py", *source_files(model_file, *more, shell)}
    return {path.relative_to(ROOT).as_posix(): path.read_bytes() for path in sorted(files)}


def python_token(model: Model, sources: dict[str, bytes]) -> str:
    """Compute the GUID of the flavour from all that goes into it."""
    contents = [part for path, text in sources.items() for part in (path.encode(), text)]
    contents = [pythonfmu.__version__.encode(), (_SLAVE + _COMPOSING).encode(), *contents]
    return guid(describe_fmi2(model, PYTHON, ""), *contents)


def build_python(
    model: Model, model_file: Path, *more: Path, starts: Mapping[str, float] | None = None
) -> bytes:
    """
    Build the FMU of a model whose module is `model_file`; `more` are the files that compose it.

    `starts` are start values of its own, by the names of its variables.
    """
    changing = [ROOT / "framework" / "starts.py"] if starts else []
    sources = python_sources(model_file, *more, *changing)
    model = with_starts(model, starts or {})
    token = python_token(model, sources)
    unique = f"{model.name}_{token[1:9]}"
    module = model_file.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
    package = f"dockloop_{unique}"
    composing = _COMPOSING.format(package=package, name=model.name) if more else ""
    if starts:
        composing += _STARTING.format(package=package, starts=dict(starts))
    slave = _SLAVE.format(package=package, module=module, composing=composing)
    contents = {f"resources/dockloop_{unique}/{path}": text for path, text in sources.items()}
    contents |= {
        "modelDescription.xml": describe_fmi2(model, PYTHON, token),
        "resources/slavemodule.txt": f"slave_{unique}".encode(),
        f"resources/slave_{unique}.py": slave.encode(),
        "documentation/externalDependencies.txt": _DEPENDENCIES.encode(),
    }
    return pack(contents | _pythonfmu_files(model.name))


def _pythonfmu_files(identifier: str) -> dict[str, bytes]:
    home = Path(pythonfmu.__file__).parent
    files = {f"resources/pythonfmu/{f.name}": f.read_bytes() for f in sorted(home.glob("*.py"))}
    for platform, ending in _BINARIES.items():
        for library in sorted((home / "resources" / "binaries" / platform).glob(f"*{ending}")):
            files[f"binaries/{platform}/{identifier}{ending}"] = library.read_bytes()
    return files
