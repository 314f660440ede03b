"""
The arrays of a MAT file up to version 7.2, read in a process of their own: SciPy may crash at a damaged one.

Run as a script with the path of the file, it writes a pickle of name to array to standard output.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any


def read_mat(path: Path) -> dict[str, Any]:
    """
    Return the arrays of a file by their names, those of a structure as `structure.field`.

    Raises:
        ValueError: If the file cannot be read, with the reason.
    """
    reader = subprocess.run(
        [sys.executable, __file__, str(path.absolute())], capture_output=True, stdin=subprocess.DEVNULL
    )
    if reader.returncode == 0:
        return dict(pickle.loads(reader.stdout))  # of this file's own making
    lines = reader.stderr.decode(errors="replace").splitlines()
    if reader.returncode != 1 or not lines:
        raise ValueError("its content is damaged")
    raise ValueError(f"no MAT file, or a damaged one ({lines[-1]})")


def _main(path: str) -> None:
    import warnings

    import numpy as np
    from scipy.io import loadmat

    warnings.simplefilter("ignore")
    try:
        contents = loadmat(path)
        found: dict[str, Any] = {}
        for key, value in contents.items():
            if not key.startswith("__"):
                _flatten(key, np.asarray(value), found)
        sys.stdout.buffer.write(pickle.dumps(found))
    except Exception as error:  # SciPy raises anything at a damaged file
        sys.exit(f"{type(error).__name__}: {' '.join(str(error).split())}")


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
    _main(sys.argv[1])
