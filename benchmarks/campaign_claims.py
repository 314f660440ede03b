"""
What campaigns claim, measured: each part prints one line of JSON.

    python benchmarks/campaign_claims.py equality [--runs 100]     rows against `dockloop run`, bit by bit
    python benchmarks/campaign_claims.py memory [--runs 3000]      of a worker after 500 runs and at the end
    python benchmarks/campaign_claims.py ishigami [--runs 8192]    Sobol indices of a function as an FMU
    python benchmarks/campaign_claims.py page [--runs 1000000]     page of a dataset of that many rows
    python benchmarks/campaign_claims.py scaling [--runs 400]      one process against two, on an idle machine

Seeds are fixed. Processor time is given where a busy machine would decide otherwise.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

PAPER = Path(__file__).parents[1] / "configs" / "campaigns" / "docking.yaml"
ISHIGAMI = '''
"""The function of Ishigami and Homma (1990) as the slope of a state."""

from fmu_sources.framework.model import Model, no_effect
from fmu_sources.framework.variables import declare, parameter, state


class Ishigami(Model):
    """y' = sin(x1) + 7 sin(x2)^2 + 0.1 x3^4 sin(x1)."""

    name = "ishigami"
    description = "A function of which the Sobol indices are known."
    variables = declare(
        parameter("x1", 0.0, "1", "First value"),
        parameter("x2", 0.0, "1", "Second value"),
        parameter("x3", 0.0, "1", "Third value"),
        state("y", "1", "Integral of the function", output=True),
    )

    def derivatives(self, t, x, u, p, m, slot=no_effect):
        sine = m.sin(p.x2)
        square = p.x3 * p.x3
        return {"y": (1.0 + 0.1 * square * square) * m.sin(p.x1) + 7.0 * sine * sine}


MODEL = Ishigami()
'''


def main() -> None:
    """Measure one part."""
    parts: dict[str, tuple[Callable[[int, Path], dict[str, Any]], int]] = {
        "equality": (equality, 100),
        "memory": (memory, 3000),
        "ishigami": (ishigami, 8192),
        "page": (page, 1_000_000),
        "scaling": (scaling, 400),
    }
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("part", choices=parts)
    parser.add_argument("--runs", type=int)
    arguments = parser.parse_args()
    measure, runs = parts[arguments.part]
    with tempfile.TemporaryDirectory() as folder:
        found = measure(arguments.runs or runs, Path(folder))
    print(json.dumps({"part": arguments.part, **found}))


def _paper(folder: Path, runs: int, **changes: Any) -> Path:
    """Write the campaign of the paper's experiment with another number of runs."""
    data = yaml.safe_load(PAPER.read_text(encoding="utf-8"))
    data["design"] = {"method": "random", "size": runs, "seed": 1}
    path = folder / "campaign.yaml"
    path.write_text(yaml.safe_dump(data | changes), encoding="utf-8")
    return path


def equality(runs: int, folder: Path) -> dict[str, Any]:
    """Compare random rows, all signals and metrics, with runs by themselves."""
    import dockloop as dl
    from master.campaign.fused import FUSED
    from master.campaign.plan import make_plan
    from master.campaign.stepper import Stepper
    from master.fuse.runs import fused_form

    plan = make_plan(_paper(folder, 50 * runs, stop_time=1.0, keep={"metrics": "all", "signals": "all"}))
    stepper = Stepper(plan, fused_form(plan.base))
    system = dl.load("experiment")
    n_equal = 0
    n_fused = 0
    for run in np.random.default_rng(1).choice(50 * runs, runs, replace=False).tolist():
        row = stepper.row(run)
        n_fused += row.made == FUSED
        alone = system.run("cfdc_fmdc", set=plan.varied.settings(plan.values(run)), stop_time=1.0)
        signals = all(np.array_equal(v, alone[n], equal_nan=True) for n, v in row.signals.items())
        metrics = {name: alone.metrics[name] for name in row.numbers}
        n_equal += signals and metrics == row.numbers
    return {"rows": runs, "equal": n_equal, "fused": n_fused, "signals": len(row.signals)}


def memory(runs: int, folder: Path) -> dict[str, Any]:
    """Look at the memory of a process after 500 runs, and at the end."""
    from master.campaign.plan import make_plan
    from master.campaign.stepper import Stepper
    from master.fuse.runs import fused_form

    plan = make_plan(_paper(folder, runs, stop_time=1.0))
    stepper = Stepper(plan, fused_form(plan.base))
    found: dict[str, Any] = {"runs": runs}
    for run in range(runs):
        stepper.row(run)
        if run + 1 == 500:
            found["mb_after_500"] = _resident()
    found["mb_at_the_end"] = _resident()
    return found


def _resident() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


def ishigami(runs: int, folder: Path) -> dict[str, Any]:
    """Compare Sobol indices of N = `runs`, which is 5 N runs of an FMU, with the exact ones."""
    from click.testing import CliRunner

    from master.campaign.dataset import read_columns
    from master.campaign.page import answers
    from master.campaign.plan import make_plan
    from master.campaign.sweep import sweep
    from master.cli import main as dockloop

    (folder / "ishigami.py").write_text(ISHIGAMI, encoding="utf-8")
    fmu = folder / "built" / "ishigami.fmu"
    built = CliRunner().invoke(
        dockloop, ["build", str(folder / "ishigami.py"), "--output", str(folder / "built")]
    )
    assert built.exit_code == 0, built.output
    system = {"name": "ishigami", "step_size": 1.0, "stop_time": 1.0, "fmus": {"f": {"source": str(fmu)}}}
    (folder / "system.yaml").write_text(yaml.safe_dump(system), encoding="utf-8")
    campaign = {
        "system": "system.yaml",
        "vary": {f"f.x{i}": {"uniform": [-float(np.pi), float(np.pi)]} for i in (1, 2, 3)},
        "design": {"method": "saltelli", "size": runs, "seed": 1},
        "keep": {"measures": {"y": {"final": "f.y"}}},
    }
    path = folder / "campaign.yaml"
    path.write_text(yaml.safe_dump(campaign), encoding="utf-8")
    plan = make_plan(path)
    sweep(plan, folder / "out", 2, page=False)
    indices = answers(plan, read_columns(folder / "out" / "runs"))["sobol"]["y"]
    v1 = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
    v2 = 49.0 / 8.0
    v13 = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    exact = {"f.x1": (v1, v1 + v13), "f.x2": (v2, v2), "f.x3": (0.0, v13)}
    total = v1 + v2 + v13
    errors = [
        abs(indices[key][kind]["value"] - share / total)
        for key, shares in exact.items()
        for kind, share in zip(("first", "total"), shares, strict=True)
    ]
    return {"N": runs, "runs": plan.sample.n_runs, "largest_error": max(errors)}


def page(runs: int, folder: Path) -> dict[str, Any]:
    """Write the page of a dataset that is made up, of all that the paper's campaign keeps."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    from master.campaign.dataset import schema
    from master.campaign.page import write_page
    from master.campaign.plan import make_plan
    from master.campaign.swept import Swept

    plan = make_plan(_paper(folder, runs))
    drawn = np.random.default_rng(1)
    (folder / "runs").mkdir()
    for part, first in enumerate(range(0, runs, 50_000)):
        some = np.arange(first, min(first + 50_000, runs))
        n = len(some)
        status = np.where(drawn.random(n) < 0.02, "diverged", "completed").astype(object)
        columns: dict[str, Any] = {
            "run": some,
            "status": status,
            "message": np.where(status == "diverged", "beyond its limit", "").astype(object),
            "seed": some,
            "wall_s": drawn.random(n),
            "stepping_s": drawn.random(n),
            "t_end": np.full(n, 10.0),
            "steps": np.full(n, 10_000),
        }
        columns |= {c.key: c.part(some) for c in plan.sample.columns}
        columns |= {name: drawn.normal(size=n) for name in plan.numbers}
        table = pa.Table.from_pydict(columns, schema=schema(plan))
        pq.write_table(table, folder / "runs" / f"part-{part:06d}.parquet", compression="zstd")
    swept = Swept(runs, {"completed": runs}, 0.0, 0.0, str(folder / "runs"), None, planned=runs)
    began = time.perf_counter()
    spent = time.process_time()
    write_page(plan, swept, folder, folder / "campaign.html")
    return {
        "rows": runs,
        "wall_s": time.perf_counter() - began,
        "processor_s": time.process_time() - spent,
        "largest_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def scaling(runs: int, folder: Path) -> dict[str, Any]:
    """Make the same runs by one process and by two."""
    from master.campaign.plan import make_plan
    from master.campaign.sweep import sweep

    plan = make_plan(_paper(folder, runs))
    walls = [sweep(plan, folder / str(n), n, page=False).wall_s for n in (1, 2)]
    return {"runs": runs, "wall_s": walls, "ratio": walls[0] / walls[1]}


if __name__ == "__main__":
    main()
