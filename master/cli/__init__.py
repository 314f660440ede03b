"""The command line: one file a subcommand, no logic of its own."""

from __future__ import annotations

import click

from .analyse import analyse
from .build import build
from .check import check
from .design_dpdc import design_dpdc
from .explain import explain
from .export_ssp import export_ssp
from .linearise import linearise
from .run import run


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="dockloop")
def main() -> None:
    """Docking hardware-in-the-loop simulation: FMUs, a co-simulation master, and its delays in the open."""


for command in (run, check, explain, analyse, design_dpdc, linearise, build, export_ssp):
    main.add_command(command)
