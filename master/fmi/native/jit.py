"""
Decorators of the functions that the compiled stepping loop calls.

Nobody calls them compiled from Python or from C: numba leaves out the wrappers for that, which take a sixth
of the time of compilation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.extending import overload, register_jitable

_WITHOUT_WRAPPERS: Any = {"no_cfunc_wrapper": True, "no_cpython_wrapper": True, "error_model": "numpy"}

inner = register_jitable(**_WITHOUT_WRAPPERS)
"""Of a function that is compiled too where compiled code calls it."""

inlined = register_jitable(forceinline=True, **_WITHOUT_WRAPPERS)
"""Of such a function that each tick runs through: its code stands where it is called."""


def compiled_form(function: Callable[..., Any]) -> Any:
    """Of a function that gives, as for numba's `overload`, what stands for `function` in compiled code."""
    return overload(function, jit_options=_WITHOUT_WRAPPERS)
