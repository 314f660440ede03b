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
    Return the arrays of a file by their names.

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
        found = {key: np.asarray(value) for key, value in contents.items() if not key.startswith("__")}
        sys.stdout.buffer.write(pickle.dumps(found))
    except Exception as error:  # SciPy raises anything at a damaged file
        sys.exit(f"{type(error).__name__}: {' '.join(str(error).split())}")


if __name__ == "__main__":
    _main(sys.argv[1])
