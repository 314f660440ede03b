"""Shared libraries from C sources: with the host's compiler, or with zig for every platform."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .errors import MissingToolError, NativeBuildError
from .fat import join
from .normalise import normalise
from .platforms import MAC_ARM, MAC_INTEL, RELEASE, Platform, host

CODE_FLAGS = (
    "-std=c11",
    "-O3",  # unrolls the loops over a model's few states: half of the time of a small model
    "-ffp-contract=off",  # no fused multiply-add: equal bits on every platform
    "-fno-math-errno",
)
FLAGS = (*CODE_FLAGS, "-fvisibility=hidden", "-fPIC", "-shared", "-s")


def compile_host(sources: Mapping[str, bytes], model_identifier: str) -> bytes:
    """Compile for this machine, with `cc` when it has one, else with zig."""
    compiler = [shutil.which("cc") or ""] if shutil.which("cc") else _zig()
    name = model_identifier + host().ending
    return _compile(sources, [*compiler, *FLAGS], name, host().link_flags)


def compile_release(sources: Mapping[str, bytes], model_identifier: str) -> dict[str, bytes]:
    """
    Compile for all platforms of a release.

    Returns:
        Path inside the FMU (`binaries/<platform>/<model_identifier>.<ending>`) to content, with the
        folders of FMI 2.0 and of FMI 3.0.
    """
    with ThreadPoolExecutor() as pool:
        built = pool.map(lambda p: compile_for(p, sources, model_identifier), RELEASE)
        binaries = dict(zip(RELEASE, built, strict=True))
    files = {}
    for platform, binary in binaries.items():
        name = model_identifier + platform.ending
        files[f"binaries/{platform.fmi3_folder}/{name}"] = binary
        files[f"binaries/{platform.fmi2_folder}/{name}"] = binary
    both = join([binaries[MAC_INTEL], binaries[MAC_ARM]])
    files[f"binaries/{MAC_ARM.fmi2_folder}/{model_identifier}{MAC_ARM.ending}"] = both
    return dict(sorted(files.items()))


def compile_for(platform: Platform, sources: Mapping[str, bytes], model_identifier: str) -> bytes:
    """Compile for one platform with zig."""
    name = model_identifier + platform.ending
    command = [*_zig(), "-target", platform.zig_target, *FLAGS]
    extra = list(platform.link_flags)
    if platform.ending == ".dylib":
        extra += ["-install_name", f"@rpath/{name}"]
    return normalise(_compile(sources, command, name, extra))


def _zig() -> list[str]:
    if importlib.util.find_spec("ziglang") is None:
        raise MissingToolError("ziglang")
    return [sys.executable, "-m", "ziglang", "cc"]


def _compile(sources: Mapping[str, bytes], command: Sequence[str], name: str, extra: Sequence[str]) -> bytes:
    """Compile in a folder of its own, named relatively so that no path gets into the binary."""
    with tempfile.TemporaryDirectory() as folder:
        for file, content in sources.items():
            (Path(folder) / file).write_bytes(content)
        c_files = sorted(file for file in sources if file.endswith(".c"))
        done = subprocess.run(
            [*command, "-o", name, *c_files, *extra], cwd=folder, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise NativeBuildError(f"native build of {name}: the compiler failed:\n{done.stderr[-4000:]}")
        return (Path(folder) / name).read_bytes()
