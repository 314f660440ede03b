"""Measured data against a model: what the model lacks."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

from master.installation import require_native


class Diagnosis:
    """
    Answer to the question what a model lacks.

    Attributes:
        report: All of it, as `dockloop diagnose --json` prints it.
        folder: Where `report.html`, `report.json`, panels and corrected FMUs are.
    """

    def __init__(self, report: dict[str, Any], folder: Path) -> None:
        self.report = report
        self.folder = folder

    @property
    def sentence(self) -> str:
        """The answer in one sentence."""
        return str(self.report["sentence"])

    @property
    def verdict(self) -> str:
        """How sure it is."""
        return str(self.report["verdict"])

    @property
    def subsystem(self) -> str | None:
        """The subsystem that lacks something; None if none does."""
        found = self.report["subsystem"]
        return None if found is None else str(found)

    @property
    def before(self) -> dict[str, dict[str, Any]]:
        """Error of the model by compared signal, on sealed rows: `rmse` in its unit, `nrmse_percent`."""
        return dict(self.report["before"])

    @property
    def after(self) -> dict[str, dict[str, Any]]:
        """The same of the corrected model."""
        return dict(self.report["after"])

    def __getitem__(self, key: str) -> Any:
        return self.report[key]

    def __repr__(self) -> str:
        return f"<Diagnosis: {self.sentence} ({self.verdict})>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(signal)}</td><td>{_number(before['rmse'])}</td>"
            f"<td>{_number(self.after[signal]['rmse'])}</td></tr>"
            for signal, before in self.before.items()
        )
        head = "<tr><th>signal</th><th>rmse before</th><th>after</th></tr>"
        return f"<b>{escape(self.sentence)}</b> ({escape(self.verdict)})<table>{head}{rows}</table>"


def diagnose(
    case: str | Path, folder: str | Path | None = None, *, progress: Callable[[str], None] | None = None
) -> Diagnosis:
    """
    Say what the model of a case lacks, add it, and compare the error before and after.

    Args:
        case: Path of a case in YAML, or the name of a shipped one (`first_case`).
        folder: Where the report goes; a temporary folder by default.
        progress: Called with what is being done.

    Raises:
        ConfigError: If the case or what it names is wrong, or CasADi is not installed.
        FmuError: If an FMU cannot be replayed on what was measured.
    """
    require_native("diagnose")
    from master.diagnosis.answer.answer import answer
    from master.stepping.opened import WORKING

    place = Path(tempfile.mkdtemp(prefix="dockloop-diagnosis-")) if folder is None else Path(folder)
    with WORKING:
        report = answer(Path(case), place, progress or _say_nothing)
    return Diagnosis(report, place)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _say_nothing(text: str) -> None:
    """Take the progress."""
