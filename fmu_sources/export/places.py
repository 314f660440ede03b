"""
Where things are: what is shipped, read-only, and what is made here, in the user's cache.

    checkout    fmus/ and configs/ next to the packages
    wheel       dockloop/fmus/ and dockloop/configs/ in it
    cache       $DOCKLOOP_CACHE, else the user's cache folder, else a folder of this process alone
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

import platformdirs

_PACKAGES = Path(__file__).parents[2]
IS_CHECKOUT = not (_PACKAGES / "dockloop" / "fmus").is_dir()
SHIPPED = _PACKAGES if IS_CHECKOUT else _PACKAGES / "dockloop"
FMU_FOLDER = SHIPPED / "fmus"
CONFIG_FOLDER = SHIPPED / "configs"


@cache
def cache_folder() -> Path:
    """Return the folder of all that is built or compiled here; it can be written."""
    folder = wanted_cache_folder()
    if can_be_written(folder):
        return folder
    private = Path(tempfile.mkdtemp(prefix="dockloop-cache-"))
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return private


def wanted_cache_folder() -> Path:
    """Return the folder that the environment names or the system gives a user; perhaps it cannot be made."""
    named = os.environ.get("DOCKLOOP_CACHE")
    return Path(named).absolute() if named else platformdirs.user_cache_path("dockloop", appauthor=False)


def can_be_written(folder: Path) -> bool:
    """Whether files can be made in a folder; makes it where it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def licence() -> bytes:
    """Return the licence, which goes into each FMU."""
    if IS_CHECKOUT:
        return (_PACKAGES / "LICENSE").read_bytes()
    from importlib.metadata import distribution

    return (distribution("dockloop").read_text("licenses/LICENSE") or "").encode()


def install_command(extra: str) -> str:
    """Return the command that installs an extra into this environment."""
    return f"pip install -e '.[{extra}]'" if IS_CHECKOUT else f"pip install 'dockloop[{extra}]'"
