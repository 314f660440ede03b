"""Native libraries, each compiled once a session."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fmu_sources.export import native
from fmu_sources.framework.model import Model
from tests.fmu_sources.export.native.native_library import GUID, VERSIONS, Fmu
from tests.fmu_sources.export.native.native_model import MODEL

pytest.importorskip("casadi")


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Model], Path]:
    """Compile a model for this machine; the path of its library."""
    folder = tmp_path_factory.mktemp("native")

    def compiled(model: Model) -> Path:
        path = folder / f"{model.name}.so"
        if not path.exists():
            path.write_bytes(native.compile_host(native.generate(model, GUID), model.name))
        return path

    return compiled


@pytest.fixture(params=VERSIONS, ids=lambda version: version.__name__)
def fmu(request: pytest.FixtureRequest, library: Callable[[Model], Path]) -> Iterator[Fmu]:
    """One instance of the specimen, in FMI 2.0 and in FMI 3.0."""
    instance = request.param(library(MODEL), MODEL)
    yield instance
    instance.free()
