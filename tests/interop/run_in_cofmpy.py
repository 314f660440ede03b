"""Run the reference experiment in CoFMPy (package cofmupy), in a process of its own: FMU, experiment.json."""

from __future__ import annotations

import csv
import json
import sys
import tempfile
from pathlib import Path

from cofmupy import Coordinator

NAME = "compensator"


def main(fmu: str, experiment: str) -> None:
    given = json.loads(Path(experiment).read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        coordinator = Coordinator()
        coordinator.start(str(write_system(Path(folder), fmu, given)))
        found = []
        for _ in range(len(given["rows"]) - 1):
            coordinator.do_step(given["step"])
            found.append([float(coordinator.get_variable((NAME, n))[-1]) for n in given["outputs"]])
    json.dump(found, sys.stdout)


def write_system(folder: Path, fmu: str, given: dict) -> Path:
    """Write the system, with the inputs as a stream of a CSV file."""
    table = folder / "inputs.csv"
    with table.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["t", *given["inputs"]])
        rows.writerows([repr(k * given["step"]), *map(repr, row)] for k, row in enumerate(given["rows"]))
    starts = {**given["parameters"], **dict(zip(given["inputs"], given["rows"][0], strict=True))}
    system = {
        "cosim_method": "gauss_seidel",
        "iterative": False,
        "fmus": [{"id": NAME, "path": fmu, "initialization": starts}],
        "connections": [
            {
                "source": {"type": "csv", "path": str(table), "variable": name, "interpolation": "nearest"},
                "target": {"id": NAME, "variable": name, "unit": ""},
            }
            for name in given["inputs"]
        ],
        "data_storages": [],
    }
    file = folder / "system.json"
    file.write_text(json.dumps(system), encoding="utf-8")
    return file


if __name__ == "__main__":
    main(*sys.argv[1:])
