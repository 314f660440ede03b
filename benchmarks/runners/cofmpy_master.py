"""
CoFMPy (package cofmupy): its default master; results kept in memory.

It sets every start value as a real, so Booleans and integers keep those of the FMU.
"""

from __future__ import annotations

import json
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from cofmupy import Coordinator
from measure import answer, timed


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    is_jacobi = len(spec["order"]) == 1
    configuration = {
        "cosim_method": "jacobi" if is_jacobi else "gauss_seidel",
        "iterative": False,
        "fmus": [
            {"id": name, "path": given["path"], "initialization": _reals(given)}
            for name, given in spec["fmus"].items()
        ],
        "connections": [
            {"source": _end(source), "target": _end(target)} for source, target in spec["connections"]
        ],
        "data_storages": [],
    }
    coordinator = Coordinator()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "system.json"
        file.write_text(json.dumps(configuration), encoding="utf-8")
        coordinator.start(str(file))

    def run() -> None:
        for _ in range(int(n_steps)):
            coordinator.do_step(spec["step_size"], save_data=False)

    seconds = timed(run)
    final = [
        (f"{name}.{v}", float(coordinator.get_variable((name, v))[-1]))
        for name, given in spec["fmus"].items()
        for v in given["outputs"]
        if given["kinds"][v] == "Real"
    ]
    answer(seconds, int(n_steps), version("cofmupy"), final)


def _reals(given: dict) -> dict[str, float]:
    return {v: x for v, x in given["start"].items() if given["kinds"][v] == "Real"}


def _end(signal: str) -> dict[str, str]:
    name, variable = signal.split(".", 1)
    return {"id": name, "variable": variable, "unit": ""}


if __name__ == "__main__":
    main(*sys.argv[1:])
