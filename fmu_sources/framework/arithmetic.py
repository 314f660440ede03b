"""
The mathematics namespace `m` that the equations are written on, for plain Python numbers.

Three other namespaces answer alike: `array_arithmetic` for NumPy arrays, `export.native.casadi_arithmetic`
for symbols that become C, `export.dependencies` for labels that remember where a number came from.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol


class Arithmetic(Protocol):
    """Functions that the equations may use; `Any` because the numbers may be symbols."""

    pi: float

    def sqrt(self, x: Any) -> Any: ...
    def exp(self, x: Any) -> Any: ...
    def log(self, x: Any) -> Any: ...
    def sin(self, x: Any) -> Any: ...
    def cos(self, x: Any) -> Any: ...
    def tan(self, x: Any) -> Any: ...
    def tanh(self, x: Any) -> Any: ...
    def floor(self, x: Any) -> Any: ...
    def fabs(self, x: Any) -> Any: ...
    def where(self, condition: Any, if_true: Any, if_false: Any) -> Any: ...
    def both(self, a: Any, b: Any) -> Any: ...
    def pick(self, values: Sequence[Any], index: Any) -> Any: ...


class PythonArithmetic:
    """`math` with `where` (both branches evaluated), `both` (logical and), `pick` (index from 0)."""

    pi = math.pi
    sqrt = staticmethod(math.sqrt)
    exp = staticmethod(math.exp)
    log = staticmethod(math.log)
    sin = staticmethod(math.sin)
    cos = staticmethod(math.cos)
    tan = staticmethod(math.tan)
    tanh = staticmethod(math.tanh)
    fabs = staticmethod(math.fabs)

    @staticmethod
    def floor(x: float) -> float:
        """Largest integer not above x, as a float."""
        return float(math.floor(x))

    @staticmethod
    def where(condition: Any, if_true: Any, if_false: Any) -> Any:
        """Choose by a condition."""
        return if_true if condition else if_false

    @staticmethod
    def both(a: Any, b: Any) -> bool:
        """Logical and of two conditions."""
        return bool(a) and bool(b)

    @staticmethod
    def pick(values: Sequence[Any], index: float) -> Any:
        """Element at a computed place; past either end the last one on that side."""
        return values[int(min(index, len(values) - 1))] if index > 0 else values[0]


PYTHON = PythonArithmetic()
