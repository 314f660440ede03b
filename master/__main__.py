"""The command `dockloop`, also `python -m master`."""

from .process.signals import end_at_once

__all__ = ["main"]


def main() -> None:
    """Run the command; a signal ends it at any moment with the status that signals have."""
    end_at_once()
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
