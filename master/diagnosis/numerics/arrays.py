"""The array types of the diagnosis; a docstring or an annotation says which shape one has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

TINY = 1e-300  # in place of a zero that is divided by
