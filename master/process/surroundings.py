"""What FMUs share with the process they run in: standard output, working folder, umask."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def standard_output_as_error() -> Iterator[None]:
    """Send what FMUs print, from Python or from C, to standard error."""
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.flush()
    try:
        output = os.dup(1)
    except OSError:  # closed from the beginning
        output = -1
    try:
        if output >= 0:
            with contextlib.suppress(OSError):
                os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        _flush()
        if output >= 0:
            with contextlib.suppress(OSError):  # an FMU may have closed it
                os.dup2(output, 1)
                os.close(output)


def working_folder() -> str | None:
    """Return the working folder, None if it is not there any more."""
    try:
        return os.getcwd()
    except OSError:
        return None


def restore_working_folder(folder: str | None) -> None:
    """Go back to the folder that `working_folder` returned, where another one is set now."""
    if folder is not None and working_folder() != folder:
        with contextlib.suppress(OSError):
            os.chdir(folder)


def _flush() -> None:
    """Write what lies in buffers of C and Python."""
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.flush()
    with contextlib.suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).fflush(None)
