"""
The arrays of a MAT file up to version 7.2, read in a process of their own: SciPy may crash at a damaged one.

Run as a script, it reads pickles of paths from standard input until that ends, and answers each on standard
output by a pickle of name to array, or of the reason why there are none. One process reads all files:
loading SciPy takes longer than reading most of them.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

_running: dict[int, subprocess.Popen[bytes]] = {}
"""The reader of this process by its number: what is forked from it begins its own."""


def read_mat(path: Path) -> dict[str, Any]:
    """
    Return the arrays of a file by their names, those of a structure as `structure.field`.

    Raises:
        ValueError: If the file cannot be read, with the reason.
    """
    reader = _reader()
    assert reader.stdin is not None
    assert reader.stdout is not None
    try:
        pickle.dump(str(path.absolute()), reader.stdin)
        reader.stdin.flush()
        answer = pickle.load(reader.stdout)  # of this file's own making
    except BaseException as error:  # whatever stops it, what it answers next would be of this file
        end_reader()
        if isinstance(error, (OSError, EOFError, pickle.UnpicklingError)):
            raise ValueError("its content is damaged") from error
        raise
    if isinstance(answer, str):
        raise ValueError(f"no MAT file, or a damaged one ({answer})")
    return dict(answer)


def _reader() -> subprocess.Popen[bytes]:
    reader = _running.get(os.getpid())
    if reader is not None and reader.poll() is not None:  # it ended between two files, by no fault of theirs
        end_reader()
        reader = None
    if reader is None:
        command = [sys.executable, __file__]
        reader = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        _running[os.getpid()] = reader
    return reader


@atexit.register
def end_reader() -> None:
    """End the reader of this process, if there is one."""
    reader = _running.pop(os.getpid(), None)
    if reader is not None:
        reader.kill()
        reader.communicate()


def _serve() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends it to this process, too
    warnings.simplefilter("ignore")
    answers = sys.stdout.buffer
    sys.stdout = sys.stderr
    while True:
        try:
            path = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        answers.write(pickle.dumps(_contents(path)))
        answers.flush()


def _contents(path: str) -> dict[str, Any] | str:
    """Return the arrays of a file, or why they cannot be read."""
    import numpy as np
    from scipy.io import loadmat

    try:
        contents = loadmat(path)
        found: dict[str, Any] = {}
        for key, value in contents.items():
            if not key.startswith("__"):
                _flatten(key, np.asarray(value), found)
    except Exception as error:  # SciPy raises anything at a damaged file
        return f"{type(error).__name__}: {' '.join(str(error).split())}"
    return found


def _flatten(key: str, value: Any, arrays: dict[str, Any]) -> None:
    """Add a field of a structure as `structure.field`, its values one by one where there is a row of them."""
    import numpy as np

    if value.dtype.names is None:
        if value.dtype.kind != "O" or value.size != 1:
            arrays[key] = value
        else:
            _flatten(key, np.asarray(value.item()), arrays)
        return
    for field in value.dtype.names:
        entries = np.ravel(value[field])
        if len(entries) == 1:
            _flatten(f"{key}.{field}", np.asarray(entries[0]), arrays)
        elif all(np.size(entry) == 1 and np.asarray(entry).dtype.kind in "fiub" for entry in entries):
            arrays[f"{key}.{field}"] = np.array([np.ravel(entry)[0] for entry in entries])


if __name__ == "__main__":
    _serve()
