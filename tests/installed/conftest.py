"""The wheel in an environment of its own, and another user who can write nothing but a folder of theirs."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
NOBODY = 65534
Done = subprocess.CompletedProcess[str]
READS_ALL = "+dac_read_search"  # the interpreter may lie in a folder that only root may enter


@dataclass(frozen=True)
class Archives:
    """What is uploaded: the sdist, and the wheel that was built from it."""

    sdist: Path
    wheel: Path


@dataclass(frozen=True)
class Stranger:
    """A user without a network and with rights on `folder` alone, which holds the home."""

    python: Path
    folder: Path

    def run(
        self, *command: str, home: str = "home", cwd: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Run a command in the folder `work`, or in `cwd`."""
        environment = {
            "PATH": f"{self.python.parent}:/usr/local/bin:/usr/bin:/bin",
            "HOME": str(self.folder / home),
            "LANG": "C.UTF-8",
        }
        return subprocess.run(
            [*_as_nobody(), *command],
            cwd=cwd or self.folder / "work",
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def dockloop(self, *arguments: str, home: str = "home") -> Done:
        """Run the command `dockloop`, which must succeed."""
        done = self.run(str(self.python.parent / "dockloop"), *arguments, home=home)
        assert done.returncode == 0, done.stderr[-3000:] + done.stdout[-1000:]
        return done


def _as_nobody() -> list[str]:
    """What makes a command that of another user, without network where the system can do that."""
    if os.geteuid() != 0 or shutil.which("setpriv") is None:
        return []
    alone = subprocess.run(["unshare", "-n", "true"], capture_output=True, check=False)
    user = ["setpriv", "--reuid", str(NOBODY), "--regid", str(NOBODY), "--clear-groups"]
    user += [f"--inh-caps={READS_ALL}", f"--ambient-caps={READS_ALL}"]
    return [*(["unshare", "-n"] if alone.returncode == 0 else []), *user]


@pytest.fixture(scope="session")
def archives(tmp_path_factory: pytest.TempPathFactory) -> Archives:
    """Build the sdist, and the wheel from the sdist."""
    folder = tmp_path_factory.mktemp("archives")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(folder)],
        cwd=PROJECT,
        check=True,
    )
    (sdist,) = folder.glob("*.tar.gz")
    pip = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(sdist)]
    subprocess.run(pip, check=True)
    (wheel,) = folder.glob("*.whl")
    return Archives(sdist, wheel)


@pytest.fixture(scope="session")
def installed_python(archives: Archives) -> Path:
    """Python of an environment that has the wheel with `[native]` and nothing of the checkout."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needs = [project["dependencies"], project["optional-dependencies"]["native"], sys.version_info]
    folder = PROJECT / "build" / f"installed-{hashlib.sha256(json.dumps(needs).encode()).hexdigest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    python = folder / "venv" / "bin" / "python"
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "complete").exists():
            subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder / "venv")], check=True)
            subprocess.run([python, "-m", "pip", "install", "-q", f"{archives.wheel}[native]"], check=True)
            (folder / "complete").touch()
        again = ["install", "-q", "--no-deps", "--force-reinstall", str(archives.wheel)]
        subprocess.run([python, "-m", "pip", *again], check=True)
    return python


@pytest.fixture(scope="session")
def readable_folder() -> Iterator[Path]:
    """Make a folder that everybody may read, unlike those of pytest."""
    folder = Path(tempfile.mkdtemp(prefix="dockloop-installed-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture(scope="session")
def stranger(installed_python: Path, readable_folder: Path) -> Stranger:
    """Another user in an empty folder."""
    folder = readable_folder / "stranger"
    for place in (folder, folder / "home", folder / "work"):
        place.mkdir(exist_ok=True)
        if os.geteuid() == 0:
            os.chown(place, NOBODY, NOBODY)
    return Stranger(installed_python, folder)
