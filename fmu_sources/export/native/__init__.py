"""The native flavour: a model as C, in one binary a platform for FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping

from ...framework.model import Model
from .compile import CODE_FLAGS, Compilation, begin_host, compile_host, compile_release
from .errors import MissingToolError, NativeBuildError
from .platforms import host_folders, of_version

__all__ = [
    "CODE_FLAGS",
    "Compilation",
    "MissingToolError",
    "NativeBuildError",
    "begin_host",
    "build_description",
    "c_files",
    "compile_host",
    "compile_release",
    "generate",
    "host_folders",
    "of_version",
]


def generate(model: Model, guid: str) -> dict[str, bytes]:
    """Generate all C files of a model: file name to content (see `codegen.generate`)."""
    if importlib.util.find_spec("casadi") is None:
        raise MissingToolError("casadi")
    from .codegen import generate as generate_sources

    return generate_sources(model, guid)


def c_files(sources: Mapping[str, bytes]) -> list[str]:
    """List the files to compile, as `SourceFiles` (FMI 2.0) names them."""
    return sorted(name for name in sources if name.endswith(".c"))


def build_description(sources: Mapping[str, bytes], model_identifier: str) -> bytes:
    """Write `sources/buildDescription.xml` of FMI 3.0."""
    files = "\n".join(f'      <SourceFile name="{name}"/>' for name in c_files(sources))
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{model_identifier}" description="One library of all C files">
    <SourceFileSet language="C11" compilerOptions="-O3 -ffp-contract=off -fno-math-errno">
{files}
    </SourceFileSet>
    <Library name="m" external="true"/>
  </BuildConfiguration>
</fmiBuildDescription>
""".encode()
