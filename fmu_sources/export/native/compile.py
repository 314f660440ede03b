"""Shared libraries from C sources: with the host's compiler, or with zig for every platform."""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
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
_MESSAGES = "messages.txt"  # of the compiler


def compile_host(sources: Mapping[str, bytes], model_identifier: str) -> bytes:
    """Compile for this machine, with `cc` when it has one, else with zig."""
    with closing(begin_host(sources, model_identifier)) as compilation:
        return compilation.library()


def begin_host(sources: Mapping[str, bytes], model_identifier: str) -> Compilation:
    """Begin what `compile_host` does."""
    cc = shutil.which("cc")
    compiler = _zig() if cc is None else [cc]
    return Compilation(sources, [*compiler, *FLAGS], model_identifier + host().ending, host().link_flags)


def compile_release(sources: Mapping[str, bytes], model_identifier: str) -> dict[str, bytes]:
    """
    Compile for all platforms of a release.

    Returns:
        Path inside the FMU (`binaries/<platform>/<model_identifier>.<ending>`) to content, with the
        folders of FMI 2.0 and of FMI 3.0.
    """
    with ExitStack() as stack:  # an exception, as of Ctrl-C, ends all compilers
        at_work = {p: stack.enter_context(closing(_begin_for(p, sources, model_identifier))) for p in RELEASE}
        binaries = {p: normalise(compilation.library()) for p, compilation in at_work.items()}
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
    with closing(_begin_for(platform, sources, model_identifier)) as compilation:
        return normalise(compilation.library())


def _begin_for(platform: Platform, sources: Mapping[str, bytes], model_identifier: str) -> Compilation:
    name = model_identifier + platform.ending
    command = [*_zig(), "-target", platform.zig_target, *FLAGS]
    extra = list(platform.link_flags)
    if platform.ending == ".dylib":
        extra += ["-install_name", f"@rpath/{name}"]
    return Compilation(sources, command, name, extra)


def _zig() -> list[str]:
    if importlib.util.find_spec("ziglang") is None:
        raise MissingToolError("ziglang")
    return [sys.executable, "-m", "ziglang", "cc"]


class Compilation:
    """A compiler at work on a library, in a folder of its own: no path gets into the binary."""

    def __init__(
        self, sources: Mapping[str, bytes], command: Sequence[str], name: str, extra: Sequence[str]
    ) -> None:
        self._name = name
        self._folder = tempfile.TemporaryDirectory()
        for file, content in sources.items():
            (Path(self._folder.name) / file).write_bytes(content)
        c_files = sorted(file for file in sources if file.endswith(".c"))
        with (Path(self._folder.name) / _MESSAGES).open("wb") as said:
            self._process = subprocess.Popen(
                [*command, "-o", name, *c_files, *extra],
                cwd=self._folder.name,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=said,
                start_new_session=True,  # so that all that a compiler starts ends with it
            )

    def is_done(self) -> bool:
        """Whether the compiler has ended."""
        return self._process.poll() is not None

    def library(self) -> bytes:
        """
        Return the library, once the compiler has ended.

        Raises:
            NativeBuildError: If the compiler fails.
        """
        folder = Path(self._folder.name)
        if self._process.wait() != 0:
            said = (folder / _MESSAGES).read_text(encoding="utf-8", errors="replace")
            raise NativeBuildError(f"native build of {self._name}: the compiler failed:\n{said[-4000:]}")
        return (folder / self._name).read_bytes()

    def close(self) -> None:
        """End the compiler if it is at work still, and remove its folder."""
        if not self.is_done():
            if sys.platform == "win32":
                self._process.kill()
            else:
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._folder.cleanup()
