"""The command line: one file a subcommand, no logic of its own."""

from __future__ import annotations

import click

from .analyse import analyse
from .build import build
from .check import check
from .explain import explain
from .run import run


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="dockloop")
def main() -> None:
    """Docking hardware-in-the-loop simulation: FMUs, a co-simulation master, and its delays in the open."""


for command in (run, check, explain, analyse, build):
    main.add_command(command)
