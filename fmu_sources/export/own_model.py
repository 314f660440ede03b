"""
Native FMUs of models that are not of this package: a file with `MODEL`, or a `Model` that a program made.

Such a file imports from `fmu_sources.framework` by that name, and may import files next to it. The GUID is
the digest of all that is generated, whatever the model is made of.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from types import ModuleType

from ..composed import registry
from ..composed.composition import SEPARATOR
from ..framework.model import Model
from ..framework.variables import Role
from .facts import guid
from .native_flavour import NativeSources, content_digest_of, host_binaries, pack_native
from .reference_data import reference_files

VERSIONS = {"native": "2.0", "fmi3": "3.0"}
_LIBRARY_FOLDERS = ("site-packages", "dist-packages")


class OwnModelError(ValueError):
    """A model that cannot be loaded or exported; the text says where and why."""


def load_model(file: Path) -> Model:
    """
    Import the model of a Python file.

    Raises:
        OwnModelError: If the file is no module with a `Model` named `MODEL`; with the line that fails.
    """
    if not file.is_file():
        raise OwnModelError(f"{file}: no such file, expected a Python file with a model named MODEL")
    name = f"dockloop_model_{hashlib.sha256(str(file.resolve()).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise OwnModelError(f"{file}: not a Python file, got {file.suffix!r}, expected .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # the documentation of the FMU is the docstring of this module
    with _importable(file.parent), _running_code_of(file):
        spec.loader.exec_module(module)
    model = getattr(module, "MODEL", None)
    if not isinstance(model, Model):
        got = "nothing" if model is None else type(model).__name__
        raise OwnModelError(f"{file}: MODEL: not a model, got {got}, expected an instance of Model")
    return model


def added(file: Path) -> str:
    """
    Load a model, check it, and make it known to the registry; return its name.

    Raises:
        OwnModelError: If it cannot be loaded, is wrong, or has the name of another model.
    """
    model = load_model(file)
    name = getattr(model, "name", None)
    if not isinstance(name, str) or not (name.isidentifier() and name.isascii()) or SEPARATOR in name:
        expected = "a name of letters, digits and single underscores"
        raise OwnModelError(f"{file}: name of the model, got {name!r}, expected {expected}")
    _check(model, file)
    try:
        registry.add(model, file)
    except ValueError as error:
        raise OwnModelError(f"{file}: {error}") from error
    return name


def own_sources(model: Model, file: Path | None = None) -> NativeSources:
    """
    Generate the C of a model; its GUID is the digest of all of it.

    Raises:
        OwnModelError: If declarations and equations do not agree.
    """
    from . import native

    _check(model, file)
    with _running_code_of(file):
        reference = {} if file is None else reference_files(model, file)
        draft = NativeSources(model, "", native.generate(model, ""), reference)
        token = guid(content_digest_of(draft).encode())
        return NativeSources(model, token, native.generate(model, token), reference)


def own_fmu(model: Model, flavour: str = "native", file: Path | None = None) -> bytes:
    """
    Generate, compile and pack the FMU of a model for this machine.

    Args:
        model: What is exported.
        flavour: `native` (FMI 2.0) or `fmi3` (FMI 3.0).
        file: Where the model is defined; its reference experiment is looked for next to it.

    Raises:
        OwnModelError: If declarations and equations do not agree.
        NativeBuildError: If this machine lacks a tool, or the compiler fails.
    """
    if flavour not in VERSIONS:
        raise OwnModelError(f"{model.name}: flavour, got {flavour!r}, expected native or fmi3")
    sources = own_sources(model, file)
    return pack_native(sources, host_binaries(sources), VERSIONS[flavour])


def _check(model: Model, file: Path | None) -> None:
    """Refuse a model whose equations do not give what it declares, or give more."""
    from ..framework.arithmetic import PYTHON

    where = model.name if file is None else f"{file}"
    with _running_code_of(file):
        groups = {
            role: [v.start for v in model.group(role)] for role in (Role.STATE, Role.INPUT, Role.PARAMETER)
        }
        x = model.states.record(groups[Role.STATE])
        u = model.inputs.record(groups[Role.INPUT])
        p = model.parameters.record(groups[Role.PARAMETER])
        found = {
            "derivatives": (model.derivatives(0.0, x, u, p, PYTHON), model.continuous.fields, True),
            "outputs": (model.outputs(0.0, x, u, p, PYTHON), model.results.fields, True),
            "update": (model.update(0.0, x, u, p, PYTHON), model.states.fields, False),
            "initial": (model.initial(x, u, p, PYTHON), model.states.fields, False),
        }
    problems = [
        f"{where}: {method}(), got {type(given).__name__}, expected a mapping of names to values"
        for method, (given, _, _) in found.items()
        if not isinstance(given, Mapping)
    ]
    if problems:
        raise OwnModelError("\n".join(problems))
    for method, (given, declared, needs_all) in found.items():
        what = "state" if method != "outputs" else "output"
        if needs_all:
            problems += [
                f"{where}: {what} {n!r} is declared, and {method}() does not return it"
                for n in declared
                if n not in given
            ]
        problems += [
            f"{where}: {method}() returns {n!r}, expected a declared {what}"
            for n in given
            if n not in declared
        ]
    if problems:
        raise OwnModelError("\n".join(problems))


@contextmanager
def _importable(folder: Path) -> Iterator[None]:
    """Let a module import files next to it while it is loaded; another folder has files of its own."""
    folder = folder.resolve()
    before = set(sys.modules)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in set(sys.modules) - before:
            is_of_known_package = name.partition(".")[0] in before
            if not is_of_known_package and _is_next_to_models(name, sys.modules[name], folder):
                del sys.modules[name]


def _is_next_to_models(name: str, module: ModuleType, folder: Path) -> bool:
    """Whether a module was found in a folder by its name; libraries are elsewhere, or below it (`.venv`)."""
    if folder.name in _LIBRARY_FOLDERS:
        return False
    file = getattr(module, "__file__", None)
    places = [file] if file is not None else list(getattr(module, "__path__", ()))
    found = {folder.joinpath(*name.split(".")), folder.joinpath(*name.split("."), "__init__")}
    return any(Path(p).with_name(Path(p).name.partition(".")[0]) in found for p in places)


@contextmanager
def _running_code_of(file: Path | None) -> Iterator[None]:
    """
    Let a model's own code run: what it raises becomes a message with its line, what it prints no result.

    Errors of a model without a file pass.
    """
    try:
        with redirect_stdout(sys.stderr):
            yield
    except (Exception, SystemExit) as error:
        if file is None or isinstance(error, OwnModelError):
            raise
        raise OwnModelError(_told(error, file)) from error


def _told(error: BaseException, file: Path) -> str:
    """Say in one line where and why a model's own code fails."""
    text = f"{type(error).__name__}: {' '.join(str(error).split()) or 'no text'}"
    if isinstance(error, SyntaxError):
        text = " ".join(error.msg.split())
        if error.filename is not None and Path(error.filename).is_file():
            return f"{error.filename}:{error.lineno}: {text}"
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if Path(f.filename).resolve() == file.resolve()]
    if own:
        return f"{file}:{own[-1].lineno}: {text}"
    if isinstance(error, SyntaxError):
        return f"{file}: {text}"
    return f"{file}: its equations cannot be exported: {text}"
