"""Signatures of FMPy's functions, which it would work out again for each FMU that it loads."""

from __future__ import annotations

import inspect
from functools import cache


@cache
def keep_signatures(kind: type) -> None:
    """Note at each FMI function of one of FMPy's classes the signature that it has."""
    for base in kind.__mro__:
        for name, function in vars(base).items():
            if name.startswith("fmi") and inspect.isfunction(function):
                function.__dict__.setdefault("__signature__", inspect.signature(function))
