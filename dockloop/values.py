"""Values of a program as those of a system file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from master.errors import ConfigError, Problem


def plain(value: Any) -> Any:
    """
    Turn values of NumPy, paths, tuples into what YAML has.

    Raises:
        ConfigError: If there is a value that a system file cannot hold.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): plain(v) for key, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(v) for v in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise ConfigError(
        [Problem("not a value", got=repr(value), expected="a number, a text, a list or a dict")]
    )
