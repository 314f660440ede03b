"""What can go wrong in a native build."""

from __future__ import annotations

from ..places import install_command


class NativeBuildError(RuntimeError):
    """A native build that failed; the text says what to do."""


class MissingToolError(NativeBuildError):
    """A build extra that is not installed."""

    def __init__(self, tool: str) -> None:
        self.tool = tool
        super().__init__(f"native build: {tool} is not installed, expected: {install_command('native')}")
