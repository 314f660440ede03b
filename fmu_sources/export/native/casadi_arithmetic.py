"""The mathematics namespace `m` for CasADi symbols, with every operation kept as it is written."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import casadi as ca


@contextmanager
def as_written() -> Iterator[None]:
    """
    Keep CasADi from simplifying expressions, so that results stay equal bit for bit.

    With simplification x / y * y becomes x, x - y + y becomes x and 3 * (2 * x) becomes 6 * x.
    """
    before = ca.GlobalOptions.getSimplificationOnTheFly()
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(before)


class CasadiArithmetic:
    """The functions of `fmu_sources.framework.arithmetic.Arithmetic` on symbols (scalars of type SX)."""

    pi = math.pi
    sqrt = staticmethod(ca.sqrt)
    exp = staticmethod(ca.exp)
    log = staticmethod(ca.log)
    sin = staticmethod(ca.sin)
    cos = staticmethod(ca.cos)
    tan = staticmethod(ca.tan)
    tanh = staticmethod(ca.tanh)
    floor = staticmethod(ca.floor)
    fabs = staticmethod(ca.fabs)

    @staticmethod
    def where(condition: Any, if_true: Any, if_false: Any) -> Any:
        """Choose by a condition; a condition known while tracing chooses at once."""
        if not isinstance(condition, ca.SX):
            return if_true if condition else if_false
        return ca.if_else(condition, if_true, if_false)

    @staticmethod
    def both(a: Any, b: Any) -> Any:
        """Logical and of two conditions."""
        return ca.logic_and(a, b)

    @classmethod
    def pick(cls, values: Sequence[Any], index: Any) -> Any:
        """Element at a computed place; past either end the last one on that side."""
        chosen = values[0]
        for i in range(1, len(values)):
            chosen = cls.where(index >= i, values[i], chosen)
        return chosen


CASADI = CasadiArithmetic()
