"""What the kernel refuses to a sandboxed process."""

from __future__ import annotations


def shut_in(folder: str) -> None:
    """Shut in."""
    raise NotImplementedError(folder)


def what_is_missing() -> str:
    """Say what this system lacks for a sandbox, empty if it has all."""
    return "not made yet"
