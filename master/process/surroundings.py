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


def _flush() -> None:
    """Write what lies in buffers of C and Python."""
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.flush()
    with contextlib.suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).fflush(None)
