"""`python -m tests.fuzz --first 1 --systems 5000`: random systems on demand; says which seeds differ."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from .compared import compile_mixer, difference


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--systems", type=int, default=5000, help="number of seeds")
    options = parser.parse_args()
    n_wrong = 0
    with tempfile.TemporaryDirectory() as scratch:
        binaries = compile_mixer(Path(scratch))
        for seed in range(options.first, options.first + options.systems):
            with tempfile.TemporaryDirectory() as folder:
                wrong = difference(seed, binaries, Path(folder))
            if wrong:
                n_wrong += 1
                print(f"seed {seed}: {wrong}", flush=True)
    print(f"{options.systems} systems, {n_wrong} not as the bare loop gives them")
    return min(n_wrong, 1)


if __name__ == "__main__":
    raise SystemExit(main())
