"""`dockloop replay`: the models of a case over its recordings, as they are or corrected."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from master.errors import ConfigError

from .common import JSON, answers_errors, calls_fmus, print_json, say


@click.command()
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--with", "other", help="`corrected`, a folder of results, or a system in its place.")
@click.option("--output", type=click.Path(path_type=Path), help="Folder for the replay as CSV.")
@JSON
@answers_errors
@calls_fmus
def replay(case: Path, other: str | None, output: Path | None, as_json: bool) -> None:
    """Replay the models of CASE on its recordings, and show the error on the sealed part."""
    try:
        from master.diagnosis.answer.replayed import corrected_system
        from master.diagnosis.answer.replayed import replay as replayed
    except ImportError as error:
        raise ConfigError([f"replay: got no {error.name}, expected pip install -e '.[native]'"]) from None
    found = replayed(case, None if other is None else corrected_system(case, other))
    errors = {signal: e for part in found.values() for signal, e in part.errors().items()}
    files = []
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        for name, part in found.items():
            file = output / f"{name.replace(' and ', '_')}.csv"
            names = list(part.part.compared)
            head = ["time", *names, *(f"{n} measured" for n in names)]
            table = np.column_stack([part.t, part.predicted, part.measured])
            np.savetxt(file, table, fmt="%.17g", delimiter=",", header=",".join(head), comments="")
            files.append(file.name)
    if as_json:
        print_json({"case": str(case), "with": other, "errors": errors, "files": files})
        return
    for signal, e in errors.items():
        shown = "not finite" if e["rmse"] is None else f"rmse {e['rmse']:.6g} ({e['nrmse_percent']:.4g} %)"
        say(f"{signal}: {shown} on the sealed part")
