"""
Marks of functions that the compiled stepping loop calls.

numba hears of them when it compiles, see `tell_numba`: to load what is kept, it need not be imported, which
would take longer than most runs.

Nobody calls these functions compiled from Python or from C: numba leaves out the wrappers for that, which
take a sixth of the time of compilation.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
Emit = Callable[[Any, list[Any]], Any]
"""From an IR builder and the values of the arguments to that of the result; None if there is none."""

_WITHOUT_WRAPPERS: Any = {"no_cfunc_wrapper": True, "no_cpython_wrapper": True, "error_model": "numpy"}


@dataclass(frozen=True)
class _Emitted:
    """Compiled code of a function, written instruction by instruction; types have the names of numba's."""

    function: Callable[..., Any]
    result: str
    arguments: tuple[str, ...]
    emit: Emit


_compiled: list[tuple[Callable[..., Any], dict[str, Any]]] = []
_emitted: list[_Emitted] = []


def inner(function: F) -> F:
    """Mark a function that is compiled too where compiled code calls it."""
    _compiled.append((function, {}))
    return function


def inlined(function: F) -> F:
    """Mark such a function that each tick runs through: its code stands where it is called."""
    _compiled.append((function, {"forceinline": True}))
    return function


def emitted(function: Callable[..., Any], result: str, *arguments: str) -> Callable[[Emit], Emit]:
    """Mark what emits the instructions for `function` in compiled code; types have the names of numba's."""

    def mark(emit: Emit) -> Emit:
        _emitted.append(_Emitted(function, result, arguments, emit))
        return emit

    return mark


def is_switched_off() -> bool:
    """Whether the environment asks for no compilation at all."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


def tell_numba() -> None:
    """Tell numba of all functions that have been marked since the last time."""
    from numba.extending import register_jitable

    while _compiled:
        function, more = _compiled.pop()
        register_jitable(**_WITHOUT_WRAPPERS, **more)(function)
    while _emitted:
        _tell_of(_emitted.pop())


def _tell_of(one: _Emitted) -> None:
    from numba import types
    from numba.core.typing.templates import Signature
    from numba.extending import lower_builtin, type_callable

    arguments = tuple(getattr(types, name) for name in one.arguments)
    whole = Signature(getattr(types, one.result), arguments, None)  # type: ignore[no-untyped-call]

    def typed(*_: Any) -> Any:
        return whole

    typed.__signature__ = inspect.signature(one.function)  # type: ignore[attr-defined]  # not one tuple

    type_callable(one.function)(lambda _: typed)

    def lowered(context: Any, builder: Any, _: Any, values: Any) -> Any:
        value = one.emit(builder, list(values))
        return context.get_dummy_value() if value is None else value

    lower_builtin(one.function, *arguments)(lowered)  # type: ignore[no-untyped-call]
