"""Parameters of tests that take minutes."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def long_for(costly: Collection[Any], parameters: Iterable[Any]) -> list[Any]:
    """Mark the costly ones of some parameters `long`."""
    return [pytest.param(*_values(p), marks=pytest.mark.long) if p in costly else p for p in parameters]


def _values(parameter: Any) -> tuple[Any, ...]:
    return parameter if isinstance(parameter, tuple) else (parameter,)
