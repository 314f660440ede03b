"""A process next to a worker of a cluster, which makes the runs that come through its standard input."""

from __future__ import annotations

import os
import pickle
import sys

from .cluster import Bundle
from .crew import Crew, Order
from .stepper import Row


def main() -> None:
    """Read a bundle, then lists of runs; answer each list with its rows, until the input ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what FMUs print is no answer
    packed: Bundle = pickle.loads(pickle.load(sys.stdin.buffer))
    crew = Crew(packed.unpacked(), 1)
    while True:
        try:
            given: list[Order] = pickle.loads(pickle.load(sys.stdin.buffer))
        except EOFError:
            crew.close()
            return
        rows: list[Row] = [row for row in crew.rows(iter(given), lambda: False, keep=True) if row is not None]
        pickle.dump(pickle.dumps(rows), answers)
        answers.flush()


if __name__ == "__main__":
    main()
