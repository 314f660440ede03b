"""The command line: one file a subcommand, no logic of its own; a file is loaded when its command is used."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from master.text.printable import printable

COMMANDS = {
    "run": "run",
    "rerun": "rerun",
    "sweep": "sweep",
    "resume": "resume",
    "compare": "compare",
    "check": "check",
    "explain": "explain",
    "show": "show",
    "analyse": "analyse",
    "preflight": "preflight",
    "linearise": "linearise",
    "commission": "commission",
    "design-dpdc": "design_dpdc",
    "compare-methods": "compare_methods",
    "rths": "rths",
    "reproduce": "reproduce",
    "case": "case",
    "diagnose": "diagnose",
    "replay": "replay",
    "build": "build",
    "export-fmu": "export_fmu",
    "export-ssp": "export_ssp",
    "examples": "examples",
    "inspect": "inspect",
    "new": "new",
    "new-model": "new_model",
    "schema": "schema",
    "doctor": "doctor",
}
GROUPS = {
    "run and look": ("run", "compare", "rerun", "resume", "sweep", "examples"),
    "understand a system": ("check", "explain", "show", "analyse", "preflight", "inspect"),
    "measured data": ("case", "diagnose", "replay"),
    "compensation": ("commission", "design-dpdc", "compare-methods", "rths", "reproduce"),
    "make and exchange": ("new", "new-model", "build", "export-fmu", "export-ssp", "linearise", "schema"),
    "the machine": ("doctor",),
}
"""Commands as `--help` lists them: by what a person wants to do."""


class _Commands(click.Group):
    """Group whose commands are in files of their own: command name to module."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        module = COMMANDS.get(cmd_name)
        if module is None:
            return None
        command = getattr(importlib.import_module(f".{module}", __package__), module)
        assert isinstance(command, click.Command)
        return command

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        with _printable_refusals():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with _printable_refusals():
            return super().invoke(ctx)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the groups, each summary whole."""
        named = {name for names in GROUPS.values() for name in names}
        others = tuple(name for name in COMMANDS if name not in named)
        for title, names in {**GROUPS, "other": others}.items():
            commands = {name: self.get_command(ctx, name) for name in names}
            rows = [(name, _summary(c)) for name, c in commands.items() if c is not None]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


@contextmanager
def _printable_refusals() -> Iterator[None]:
    """Let no word of the command line that is refused, the name of a file perhaps, control the terminal."""
    try:
        yield
    except click.ClickException as error:
        vars(error)["message"] = printable(error.message)  # declared final, though read when it is shown
        raise


def _summary(command: click.Command) -> str:
    """First paragraph of a command's help, in one line."""
    return " ".join((command.help or "").strip().split("\n\n")[0].split())


@click.command(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="dockloop")
def main() -> None:
    """Docking hardware-in-the-loop simulation: FMUs, a co-simulation master, and its delays in the open."""
