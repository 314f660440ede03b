"""The command `dockloop`, also `python -m master`."""

import os

from .process.signals import end_at_once

__all__ = ["main"]


def main() -> None:
    """Run the command; a signal ends it at any moment with the status that signals have."""
    end_at_once()
    # pydantic would search all installed packages for plug-ins, which takes longer than to check a system
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
