"""The command `dockloop`, also `python -m master`."""

from .cli import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
