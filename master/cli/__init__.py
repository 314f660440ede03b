"""The command line: one file a subcommand, no logic of its own; a file is loaded when its command is used."""

from __future__ import annotations

import importlib

import click

COMMANDS = {
    "run": "run",
    "check": "check",
    "explain": "explain",
    "analyse": "analyse",
    "linearise": "linearise",
    "design-dpdc": "design_dpdc",
    "reproduce": "reproduce",
    "diagnose": "diagnose",
    "replay": "replay",
    "build": "build",
    "export-ssp": "export_ssp",
}


class _Commands(click.Group):
    """Group whose commands stand in files of their own: command name to module."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        module = COMMANDS.get(cmd_name)
        if module is None:
            return None
        command = getattr(importlib.import_module(f".{module}", __package__), module)
        assert isinstance(command, click.Command)
        return command


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="dockloop")
def main() -> None:
    """Docking hardware-in-the-loop simulation: FMUs, a co-simulation master, and its delays in the open."""
