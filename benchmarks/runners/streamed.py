"""A long run of our master whose rows go to disk; answers its time a step and its largest resident memory."""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from pathlib import Path

from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.recording.files import ResultFiles
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

KEPT_ROWS = 10_000


def main(config: str, seconds: str) -> None:
    """Run and answer."""
    experiment = prepare_to_run(Path(config), Request(stop_time=float(seconds)))
    keep_every = -(-experiment.grid.n_ticks // KEPT_ROWS)
    with tempfile.TemporaryDirectory() as folder, ResultFiles(Path(folder)) as files:
        options = RunOptions(sink=files, keep_every=keep_every)
        begin = time.process_time()
        outcome = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)
        spent = time.process_time() - begin
        size = files.csv.stat().st_size
    assert outcome.status == "completed", outcome.cause
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    answer = {"us_per_step": 1e6 * spent / outcome.steps, "peak_bytes": peak, "csv_bytes": size}
    print(json.dumps(answer))


if __name__ == "__main__":
    main(*sys.argv[1:])
