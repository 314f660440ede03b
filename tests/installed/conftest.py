"""The wheel in an environment of its own, and another user who can write nothing but a folder of theirs."""

from __future__ import annotations

import fcntl
import hashlib
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.reliability.packages import digest, oldest, requirements

PROJECT = Path(__file__).parents[2]
NOBODY = 65534
ZIG = importlib.metadata.distribution("ziglang").locate_file("ziglang")
Done = subprocess.CompletedProcess[str]
TOOLS = ("pytest>=8", "pytest-cov>=5", "hypothesis>=6.100")  # of the sample of the tests that is run there
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


@contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """Keep other processes of the tests out of a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def archives(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Archives:
    """Build the sdist, and the wheel from the sdist, once for all processes of a session."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if hasattr(request.config, "workerinput") else own) / "archives"
    with _alone_in(folder):
        if not list(folder.glob("*.whl")):
            sdist = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(folder)]
            subprocess.run(sdist, cwd=PROJECT, check=True)
            (made,) = folder.glob("*.tar.gz")
            wheel = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", str(folder), str(made)]
            subprocess.run(wheel, check=True)
    return Archives(*folder.glob("*.tar.gz"), *folder.glob("*.whl"))


def oldest_versions() -> list[str]:
    """Return the lower bounds of the dependencies; zig is the newest, as a release is built with it."""
    native = [one for one in requirements("native") if one[0] != "ziglang"]
    return oldest([*requirements(), *native])


def _share_zig(venv: Path) -> None:
    """Put the zig of the tests in the place of the same in an environment, whose path is no other then."""
    (packages,) = venv.glob("lib/python*/site-packages")
    if (packages / f"ziglang-{importlib.metadata.version('ziglang')}.dist-info").is_dir():
        shutil.rmtree(packages / "ziglang")
        (packages / "ziglang").symlink_to(ZIG)


def _copy_what_zig_has_compiled(home: Path) -> None:
    """Save a stranger the minute that the libraries of Windows take: zig knows them by its own path."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "zig"
    if cache.is_dir():
        shutil.copytree(cache, home / ".cache" / "zig", ignore=shutil.ignore_patterns("tmp"))


@pytest.fixture(scope="session")
def installed_python(archives: Archives) -> Path:
    """
    Python of an environment that has the wheel with `[native]` and nothing of the checkout.

    It has the oldest versions that `pyproject.toml` allows; the environment of the tests has newest ones.
    """
    about = [oldest_versions(), requirements("native"), TOOLS, sys.version_info, str(ZIG)]
    folder = PROJECT / "build" / f"installed-{hashlib.sha256(json.dumps(about).encode()).hexdigest()[:12]}"
    python = folder / "venv" / "bin" / "python"
    pip = [python, "-m", "pip", "install", "-q", "--no-cache-dir"]
    has = folder / "wheel.sha256"
    with _alone_in(folder):
        if not has.exists():
            subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder / "venv")], check=True)
            bounds = folder / "oldest.txt"
            bounds.write_text("\n".join(oldest_versions()) + "\n", encoding="utf-8")
            subprocess.run([*pip, "-c", bounds, f"{archives.wheel}[native]", *TOOLS], check=True)
            _share_zig(folder / "venv")
        elif has.read_text(encoding="utf-8") != digest(archives.wheel):
            subprocess.run([*pip, "--no-deps", "--force-reinstall", archives.wheel], check=True)
        has.write_text(digest(archives.wheel), encoding="utf-8")
    return python


@pytest.fixture(scope="module")
def readable_folder() -> Iterator[Path]:
    """Make a folder that everybody may read, unlike those of pytest."""
    folder = Path(tempfile.mkdtemp(prefix="dockloop-installed-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture(scope="module")
def stranger(installed_python: Path, readable_folder: Path) -> Stranger:
    """Another user in a folder with nothing but what zig has compiled for the tests."""
    folder = readable_folder / "stranger"
    (folder / "work").mkdir(parents=True)
    (folder / "home").mkdir()
    _copy_what_zig_has_compiled(folder / "home")
    if os.geteuid() == 0:
        for place in (folder, *folder.rglob("*")):
            os.chown(place, NOBODY, NOBODY)
    return Stranger(installed_python, folder)
