"""The command `dockloop`, also `python -m master`."""

import os

from .process import signals

__all__ = ["main"]


def main() -> None:
    """Run the command; a signal ends it at any moment with the status that signals have."""
    signals.end_at_once()
    try:
        from .process import temporary

        temporary.make()
        # pydantic would search all installed packages for plug-ins, which takes longer than to check a system
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        from .cli import main as command

        command()
    finally:
        signals.ignore()
        temporary.remove()
        signals.end_as_the_system_does()
        signals.exit_if_unheeded()


if __name__ == "__main__":
    main()
