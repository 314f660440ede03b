"""What a campaign has come to."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass
class Swept:
    """
    What a campaign has come to; the fields are the keys of `--json`.

    `statuses` counts the runs of the dataset by status; `wall_s` is the time of this command's runs [s],
    `stepping_share` that of it in which the processes stepped, mean of all; `ended` says why it ended early;
    `tuned` is what a search found, at which the runs were made then; `fused` counts this command's runs in
    the fused form, `apart` the others by the reason; `discarded` counts the rows that were removed
    as the fused form had shown other bits; their runs are made again with the FMUs.
    """

    runs: int
    statuses: dict[str, int]
    wall_s: float
    stepping_share: float
    dataset: str
    page: str | None
    planned: int = 0
    ended: str = ""
    interval: dict[str, Any] | None = None
    restarts: int = 0
    tuned: dict[str, Any] | None = None
    fused: int = 0
    apart: dict[str, int] = field(default_factory=dict)
    discarded: int = 0
    interruption: int | None = field(default=None, repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        found = asdict(self)
        del found["interruption"]
        return found
