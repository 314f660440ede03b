"""The command `dockloop`, also `python -m master`."""

import os

from .process import signals

__all__ = ["main"]


def main() -> None:
    """Run the command; a signal ends it at any moment with the status that signals have."""
    signals.end_at_once()
    from .process import temporary

    try:
        temporary.make()
        # pydantic would search all installed packages for plug-ins, which takes longer than to check a system
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        _give_matplotlib_a_place()
        from .cli import main as command

        command()
    finally:
        signals.ignore()
        temporary.remove()
        signals.end_as_the_system_does()
        signals.exit_if_unheeded()


def _give_matplotlib_a_place() -> None:
    """Let it keep its fonts in our cache where there is no home to write to; it complains otherwise."""
    if "MPLCONFIGDIR" not in os.environ and not os.access(os.path.expanduser("~"), os.W_OK):
        from .installation import cache_folder

        os.environ["MPLCONFIGDIR"] = str(cache_folder() / "matplotlib")


if __name__ == "__main__":
    main()
