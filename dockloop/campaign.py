"""Campaigns: many runs with varied values, as one table."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from master.campaign.campaign import campaign_of
from master.campaign.dataset import read_columns
from master.campaign.page import answers
from master.campaign.plan import Plan, make_plan, plan_of
from master.campaign.sweep import sweep as make_runs
from master.campaign.swept import Swept
from master.installation import NOTEBOOK, require
from master.text.yaml_lines import parse_yaml

from .values import plain


class Campaign:
    """
    The runs of a campaign; made by `sweep`.

    Attributes:
        folder: Where dataset and page are.
        statuses: Number of runs by status.
        page: Path of the page.
        units: Units of inputs, numbers and signals by name.
    """

    def __init__(self, plan: Plan, swept: Swept, folder: Path) -> None:
        self._plan = plan
        self._swept = swept
        self.folder = folder
        self.statuses = dict(swept.statuses)
        self.page = None if swept.page is None else Path(swept.page)
        self.units = dict(plan.units)

    def __len__(self) -> int:
        return self._swept.runs

    def __getitem__(self, name: str) -> NDArray[Any]:
        """One column of the dataset, shape (runs,), in the order of the runs; KeyError if there is none."""
        return self._columns([name])[name]

    def answers(self) -> dict[str, Any]:
        """Share that diverged, description of each number, Sobol indices of a Saltelli design; as numbers."""
        return answers(self._plan, self._columns(None))

    def to_pandas(self) -> Any:
        """
        Return a `pandas.DataFrame`: index `run`, a column an input, outcome or number, units in `attrs`.

        Raises:
            ConfigError: If pandas is not installed.
        """
        require(NOTEBOOK, "to_pandas", ["pandas"])
        import pandas as pd

        columns = self._columns(None)
        frame = pd.DataFrame({name: values for name, values in columns.items() if name != "run"})
        frame.index = pd.Index(columns["run"], name="run")
        frame.attrs = {"units": self.units}
        return frame

    def to_xarray(self) -> Any:
        """
        Return an `xarray.Dataset` over `run`, of a whole grid over the varied values; units in `attrs`.

        Raises:
            ConfigError: If xarray is not installed.
        """
        require(NOTEBOOK, "to_xarray", ["xarray"])
        import xarray as xr

        columns = self._columns(None)
        free = self._plan.sample.free
        is_grid = (
            self._plan.campaign.design.method == "grid" and len(columns["run"]) == self._plan.sample.n_runs
        )
        keys = [column.key for column in free] if is_grid else []
        axes = {key: list(dict.fromkeys(columns[key].tolist())) for key in keys}
        is_grid = is_grid and int(np.prod([len(v) for v in axes.values()])) == len(columns["run"])
        dims = tuple(axes) if is_grid else ("run",)
        shape = tuple(len(v) for v in axes.values()) if is_grid else (-1,)
        data = {
            name: (dims, values.reshape(shape), {"unit": self.units.get(name, "1")})
            for name, values in columns.items()
            if name not in dims and name not in self._plan.signals
        }
        coords = axes if is_grid else {"run": columns["run"]}
        return xr.Dataset(data, coords=coords, attrs={"name": self._plan.name})

    def _columns(self, names: list[str] | None) -> dict[str, NDArray[Any]]:
        try:
            return read_columns(Path(self._swept.dataset), names)
        except (KeyError, ValueError):
            known = (*self.units, "status", "message", "wall_s")
            raise KeyError(f"no such column, got {names}, expected one of {', '.join(known)}") from None

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {status}" for status, n in self.statuses.items())
        return f"<Campaign {self._plan.name}: {len(self)} runs, {counts or 'none'}>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{escape(s)}</td><td>{n}</td></tr>" for s, n in self.statuses.items())
        return f"<b>{escape(repr(self)[1:-1])}</b><table>{rows}</table>"


def sweep(
    campaign: str | Path | Mapping[str, Any],
    folder: str | Path | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
) -> Campaign:
    """
    Make the runs of a campaign, in processes of their own.

    Args:
        campaign: Path of a YAML file as `dockloop sweep` takes it, or its content as a dict; then paths in it
            start from the working folder.
        folder: For dataset and page; a temporary folder by default.
        workers: Number of processes; one a core by default.
        scheduler: Address of a Dask cluster that makes the runs instead.
        resume: Go on with the campaign that is in the folder.

    Raises:
        ConfigError: With every fault of the campaign and its system.
        DataError: If the folder cannot be written, or holds a campaign and is not to be resumed.
        KeyboardInterrupt: If it was interrupted; the runs that were made are in the folder.
    """
    if isinstance(campaign, Mapping):
        text = yaml.safe_dump(plain(campaign), sort_keys=False, allow_unicode=True, width=10**6)
        document = parse_yaml(text, Path("campaign"))
        plan = plan_of(campaign_of(document), document)
    else:
        plan = make_plan(Path(campaign))
    place = Path(tempfile.mkdtemp(prefix="dockloop-campaign-")) if folder is None else Path(folder)
    n = workers or len(os.sched_getaffinity(0))
    swept = make_runs(plan, place, n, scheduler=scheduler, resume=resume)
    if swept.interruption is not None:
        raise KeyboardInterrupt
    return Campaign(plan, swept, place)
