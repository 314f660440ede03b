"""Cells: what is not as believed. Written as YAML, several in a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from master.text.fields import Section
from master.text.validation import validated
from master.text.yaml_lines import read_yaml

SHIPPED = Path(__file__).with_name("cells.yaml")


class Prior(Section):
    """Factors on what the methods believe: stiffness, damping, lags of motion simulator and sensor."""

    k: float = Field(default=1.0, gt=0.0)
    c: float = Field(default=1.0, ge=0.0)
    lag: float = Field(default=1.0, gt=0.0)
    T_f: float = Field(default=1.0, ge=0.0)


class Cell(Section):
    """
    Changes to a system, and to what methods believe.

    `set`: signal to a value, or to a text `FACTOR signal`, the factor times the configuration's value.
    `laws`: instance to the model with effects that takes its place. `events` as in a system file; a jitter
    gets the seed of the run. `s_act_noise` [m]: deviation of white noise on the measured displacement.
    `told`: parameters of the methods that have them. `configs`: those that the cell is for; else all.
    """

    set: dict[str, float | str] = Field(default_factory=dict)
    prior: Prior = Field(default_factory=Prior)
    laws: dict[str, str] = Field(default_factory=dict)
    events: list[dict[str, Any]] = Field(default_factory=list)
    s_act_noise: float = Field(default=0.0, ge=0.0)
    told: dict[str, float] = Field(default_factory=dict)
    stop_time: float | None = Field(default=None, gt=0.0)
    configs: list[str] | None = None


class Cells(Section):
    """A file of cells by name."""

    cells: dict[str, Cell] = Field(examples=[{"stiffer": {"prior": {"k": 0.8}}}])


def read_cells(path: Path = SHIPPED) -> dict[str, Cell]:
    """
    Read a file of cells.

    Raises:
        ConfigError: With every fault of the file.
    """
    return validated(Cells, read_yaml(path), "file of cells").cells
