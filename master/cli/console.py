"""The console of messages and progress; a file of its own, since `rich` takes its time to load."""

from __future__ import annotations

from rich.console import Console

STDERR = Console(stderr=True, highlight=False, soft_wrap=True)
