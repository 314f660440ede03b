"""The command `dockloop`, also `python -m master`."""

import _signal  # without `signal`, which takes a thousand times as long to load
import gc
import os
import sys

__all__ = ["main"]


def _end(number: int, _: object) -> None:
    """Exit with the status that signals have: nothing is there yet that would have to be cleaned up."""
    os._exit(128 + number)


if __name__ != "__mp_main__":  # as which the processes that work for this one load this file
    for _name in ("SIGINT", "SIGTERM", "SIGHUP"):  # before any import that a signal may interrupt
        if hasattr(_signal, _name):
            _signal.signal(getattr(_signal, _name), _end)


def main() -> None:
    """Run the command; a signal ends it at any moment with the status that signals have."""
    from .process import memory, signals

    signals.end_at_once()
    sys.unraisablehook = _unraisable
    from .process import temporary

    try:
        temporary.make()
        gc.set_threshold(50_000, 20, 100)  # what imports make stays: to look through it is a tenth of a start
        # pydantic would search all installed packages for plug-ins, which takes longer than to check a system
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        # matrices of a loop are small: threads of numpy's linear algebra would only wait for each other
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        _give_matplotlib_a_place()
        from .cli import main as command

        command()
    except Exception as error:  # of a library that is loaded; what a command itself meets is said there
        if not memory.is_of_memory(error):
            raise
        sys.stderr.write(f"{memory.TOO_LITTLE_MEMORY}\n")
        sys.exit(2)
    finally:
        signals.ignore()
        temporary.remove()
        signals.end_as_the_system_does()
        signals.exit_if_unheeded()


def _unraisable(said: "sys.UnraisableHookArgs") -> None:
    """Leave out what a library cannot raise for want of memory: the command's own words follow."""
    from .process import memory

    if said.exc_type is not MemoryError and not (said.exc_value and memory.is_of_memory(said.exc_value)):
        sys.__unraisablehook__(said)


def _give_matplotlib_a_place() -> None:
    """Let it keep its fonts in our cache where there is no home to write to; it complains otherwise."""
    if "MPLCONFIGDIR" not in os.environ and not os.access(os.path.expanduser("~"), os.W_OK):
        from .installation import cache_folder

        os.environ["MPLCONFIGDIR"] = str(cache_folder() / "matplotlib")


if __name__ == "__main__":
    main()
