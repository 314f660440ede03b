"""The mathematics namespace `m` for NumPy arrays: the equations at many instants at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class ArrayArithmetic:
    """The functions of `fmu_sources.framework.arithmetic.Arithmetic` on numbers and arrays that broadcast."""

    pi = float(np.pi)
    sqrt = staticmethod(np.sqrt)
    exp = staticmethod(np.exp)
    log = staticmethod(np.log)
    sin = staticmethod(np.sin)
    cos = staticmethod(np.cos)
    tan = staticmethod(np.tan)
    tanh = staticmethod(np.tanh)
    floor = staticmethod(np.floor)
    fabs = staticmethod(np.fabs)
    where = staticmethod(np.where)
    both = staticmethod(np.logical_and)

    @staticmethod
    def pick(values: Sequence[Any], index: Any) -> Any:
        """Element at each computed place; past either end the last one on that side."""
        places = np.where(index > 0, np.minimum(index, len(values) - 1), 0).astype(int)
        *rows, places = np.broadcast_arrays(*values, places)
        return np.take_along_axis(np.stack(rows), places[np.newaxis], axis=0)[0]


ARRAYS = ArrayArithmetic()
