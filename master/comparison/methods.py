"""Methods by name: the model that a name means, and its own settings."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from master import catalogue
from master.errors import ConfigError, expected

PAPER = "compensator"
PRESETS: dict[str, dict[str, Any]] = {
    "L": {"preset": "L"},
    "F": {"preset": "F"},
    "Q": {
        **{"preset": "custom", "P0_ab": 1e-10, "P0_cde": 1.0, "Q_ab": 0.0, "Q_cde": 1.0},
        **{"R": 1e-3, "prefilter_frequency": 0.0},
    },
}
"""Tunings of the identifier; Q, with process noise, is that of configs/time_varying_stiffness.yaml."""


@dataclass(frozen=True)
class Method:
    """A name, its model and the values that make it this method."""

    name: str
    model: str
    values: dict[str, Any] = field(default_factory=dict)

    def takes(self) -> set[str]:
        """Return the names of the parameters that the model has."""
        return set(catalogue.parameters(self.model))


def all_methods() -> dict[str, Method]:
    """Map names to methods: those of the suite, and the paper's compensator with each tuning."""
    found = {name: Method(name, name) for name in catalogue.compensation_methods()}
    parts = {"cfdc": True, "dpdc": True, "identifier": "kalman"}
    for name, tuning in PRESETS.items():
        found[f"paper_{name}"] = Method(f"paper_{name}", PAPER, {**parts, **tuning})
    return found


def chosen(text: str) -> list[Method]:
    """
    Return the methods that a text names, `all` or names with commas.

    Raises:
        ConfigError: With every name that is none.
    """
    known = all_methods()
    names = list(known) if text == "all" else list(dict.fromkeys(n.strip() for n in text.split(",")))
    wrong = [n for n in names if n not in known]
    if wrong:
        raise ConfigError(
            [f"--methods: no such method, got {name!r}, {expected(name, [*known, 'all'])}" for name in wrong]
        )
    return [known[name] for name in names]
