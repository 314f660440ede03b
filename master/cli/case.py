"""`dockloop case`: a case drafted from recordings, every guess marked."""

from __future__ import annotations

import os
from pathlib import Path

import click

from master.errors import ConfigError, Problem
from master.recording.folder import reason

from .common import answers_errors, say


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("case.yaml"),
    show_default=True,
    metavar="CASE",
    help="The file to write; none is replaced.",
)
@answers_errors
def case(files: tuple[Path, ...], output: Path) -> None:
    """Draft a case from recordings: what columns show, and a model to start from; guesses are marked."""
    from master.diagnosis.data.columns_picture import draw_columns
    from master.diagnosis.data.draft import case_text, facts_of, report

    written = (output, output.with_suffix(".png"))
    there = [file for file in written if file.exists()]
    if there:
        said = [Problem("is there already", where=str(file), expected="another --output") for file in there]
        raise ConfigError(said)
    facts = [facts_of(file) for file in files]
    names = [c.name for c in facts[0].columns]
    problems = [
        f"{own.table.path}: columns, got {[c.name for c in own.columns]}, expected {names} as in {files[0]}"
        for own in facts[1:]
        if [c.name for c in own.columns] != names
    ]
    if problems:
        raise ConfigError(problems)
    folder = output.absolute().parent
    shown = [os.path.relpath(file, folder) for file in files]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        output.write_text(case_text(output.stem, shown, facts[0]), encoding="utf-8")
    except OSError as error:
        raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(output))]) from None
    for own in facts:
        for line in report(own):
            say(line)
    say(f"{draw_columns(facts, output.with_suffix('.png'))}: all columns")
    say(f"{output}: a draft; look at each line that says 'guess', then dockloop check {output}")
