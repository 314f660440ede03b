"""The platforms of a release: what the compiler calls them, where FMI 2.0 and FMI 3.0 expect the binary."""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Platform:
    """One platform; `fmi2_folder` and `fmi3_folder` are names below `binaries/`."""

    zig_target: str
    fmi2_folder: str
    fmi3_folder: str
    ending: str
    link_flags: tuple[str, ...] = ()


# Optimised across files where the linker can: a step is short, and the calls between files count.
LINUX_FLAGS = ("-lm", "-flto")

LINUX = Platform("x86_64-linux-gnu.2.17", "linux64", "x86_64-linux", ".so", LINUX_FLAGS)
LINUX_ARM = Platform("aarch64-linux-gnu.2.17", "linuxaarch64", "aarch64-linux", ".so", LINUX_FLAGS)
WINDOWS = Platform("x86_64-windows-gnu", "win64", "x86_64-windows", ".dll")
MAC_INTEL = Platform("x86_64-macos.11.0", "darwin64", "x86_64-darwin", ".dylib")
MAC_ARM = Platform("aarch64-macos.11.0", "darwin64", "aarch64-darwin", ".dylib")
RELEASE = (LINUX, WINDOWS, LINUX_ARM, MAC_INTEL, MAC_ARM)


def of_version(binaries: Mapping[str, bytes], fmi_version: str) -> dict[str, bytes]:
    """Choose from a release the binaries in the folders of FMI "2.0" or "3.0"."""
    folders = {p.fmi2_folder if fmi_version.startswith("2") else p.fmi3_folder for p in RELEASE}
    return {path: content for path, content in binaries.items() if path.split("/")[1] in folders}


def host() -> Platform:
    """Give the platform of this machine."""
    arm = platform.machine().lower() in ("aarch64", "arm64")
    if sys.platform == "win32":
        return WINDOWS
    if sys.platform == "darwin":
        return MAC_ARM if arm else MAC_INTEL
    return LINUX_ARM if arm else LINUX


def host_folders() -> tuple[tuple[str, str], ...]:
    """Folder below `binaries/` and file ending for this machine, in FMI 2.0 and in FMI 3.0."""
    here = host()
    return (here.fmi2_folder, here.ending), (here.fmi3_folder, here.ending)
