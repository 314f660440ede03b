"""
A system as a picture: its FMUs in the order in which they step, and the age of the value on every wire.

A box lists its inputs: where each comes from and how old its value is. Wires from earlier boxes run on the
right, those from later ones, whose values are of the step before, dashed on the left.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from master.coupling.ledger import Entry
from master.errors import DataError
from master.experiment.experiment import Experiment
from master.pages.palette import LIGHT
from master.pages.plain_text import as_written
from master.recording.folder import reason

_ROW = 1.0  # height of a line of text; the unit of lengths
_CHARACTER = 0.52
_GAP = 0.8  # between boxes
_LANE = 0.7  # between wires that run side by side
_INCH = 0.2  # a unit
_FONT = 9.0  # pt
_MOST_INCHES = 200.0


@dataclass(frozen=True)
class Box:
    """An FMU: its place in the order, its title, and the wires that end at it."""

    name: str
    title: str
    inputs: tuple[Entry, ...]
    top: float

    @property
    def bottom(self) -> float:
        """Lower edge."""
        return self.top - _ROW * (1 + len(self.inputs)) - 0.4

    def row(self, place: int) -> float:
        """Middle of a line of text: 0 is the title, 1 the first input."""
        return self.top - _ROW * (place + 0.5) - 0.2


def age(entry: Entry) -> str:
    """Say how old a value is when it is used: steps, and seconds with what the target adds."""
    steps = f"{entry.least}" if entry.least == entry.most else f"{entry.least} to {entry.most}"
    plural = "" if steps == "1" else "s"
    return f"{steps} step{plural}, {1e3 * entry.seconds:.4g} ms"


def input_line(entry: Entry) -> str:
    """Describe a wire at its target."""
    return f"{entry.target.partition('.')[2]}  from  {entry.source}:  {age(entry)}"


def boxes(experiment: Experiment) -> list[Box]:
    """Place the FMUs of a system one below the other, in the order in which they step."""
    entries = experiment.ledger.entries
    found: list[Box] = []
    top = 0.0
    for place, group in enumerate(experiment.schedule.groups, start=1):
        for name in group.members:
            source = experiment.config.fmus[name].source
            every = experiment.schedule.every[name]
            together = (
                ""
                if len(group.members) == 1
                else ", with " + ", ".join(other for other in group.members if other != name)
            )
            rate = "" if every == 1 else f", every {every} ticks"
            own = tuple(e for e in entries if e.target.partition(".")[0] == name)
            box = Box(name, f"{place}. {name} ({source}){together}{rate}", own, top)
            found.append(box)
            top = box.bottom - _GAP
    outlets = tuple(e for e in entries if e.target.partition(".")[0] not in experiment.system.instances)
    if outlets:
        found.append(Box("", "outputs of the system", outlets, top))
    return found


def draw_diagram(experiment: Experiment) -> Any:
    """Draw a system; returns a figure of Matplotlib that belongs to no window."""
    from matplotlib.figure import Figure

    placed = boxes(experiment)
    texts = [text for box in placed for text in (box.title, *map(input_line, box.inputs))]
    wide = _CHARACTER * max(map(len, texts)) + 2.0
    lanes = _lanes(placed)
    left = -_LANE * (sum(1 for side, _ in lanes if side < 0) + 1)
    right = wide + _LANE * (sum(1 for side, _ in lanes if side > 0) + 1)
    low = placed[-1].bottom - 1.0
    size = (min(_MOST_INCHES, _INCH * (right - left)), min(_MOST_INCHES, _INCH * (1.8 - low)))
    figure = Figure(figsize=size)
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set(xlim=(left, right), ylim=(low, 1.8))
    axis.set_axis_off()
    step = 1e3 * experiment.grid.step_size
    _write(
        axis,
        left + 0.3,
        1.0,
        f"{experiment.title}: one tick is {step:g} ms; age of each value when it is used",
    )
    for box in placed:
        _draw_box(axis, box, wide)
    _draw_wires(axis, placed, lanes, wide)
    return figure


def save_diagram(experiment: Experiment, path: Path) -> Path:
    """
    Write a diagram as SVG or PNG, by the ending of the path.

    Raises:
        DataError: If it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(_rendered(experiment, path.suffix.lower().lstrip(".")))
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {reason(error)}") from None
    return path


def diagram_uri(experiment: Experiment) -> str:
    """Draw a diagram as SVG, and return it as the address of an image in a page."""
    return f"data:image/svg+xml;base64,{base64.b64encode(_rendered(experiment, 'svg')).decode()}"


def _rendered(experiment: Experiment, form: str) -> bytes:
    from matplotlib import rc_context

    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if form == "svg" else None
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "dockloop"}):
        as_written(draw_diagram(experiment)).savefig(buffer, format=form, metadata=metadata, dpi=110)
    return buffer.getvalue()


Lane = tuple[int, str]
"""Side (1 right, -1 left) and the FMU whose wires run there."""


def _lanes(placed: Sequence[Box]) -> dict[Lane, int]:
    """Number the lanes of each side from the boxes outwards; all wires of an FMU on a side share one."""
    order = {box.name: i for i, box in enumerate(placed)}
    found: dict[Lane, int] = {}
    for i, box in enumerate(placed):
        for entry in box.inputs:
            source = entry.source.partition(".")[0]
            if source not in order:
                continue
            side = 1 if order[source] < i else -1
            found.setdefault((side, source), 1 + sum(1 for other, _ in found if other == side))
    return found


def _draw_box(axis: Any, box: Box, wide: float) -> None:
    from matplotlib.patches import Rectangle

    height = box.top - box.bottom
    axis.add_patch(Rectangle((0.0, box.bottom), wide, height, facecolor="#f3f5f7", edgecolor=LIGHT[4]))
    _write(axis, 0.6, box.row(0), box.title, weight="bold")
    for place, entry in enumerate(box.inputs, start=1):
        _write(axis, 0.9, box.row(place), input_line(entry))


def _write(axis: Any, x: float, y: float, text: str, weight: str = "normal") -> None:
    plain = text.replace("$", r"\$")  # no formula
    axis.text(x, y, plain, fontsize=_FONT, weight=weight, va="center", ha="left", color=LIGHT[4])


def _draw_wires(axis: Any, placed: Sequence[Box], lanes: dict[Lane, int], wide: float) -> None:
    by_name = {box.name: box for box in placed}
    order = {box.name: i for i, box in enumerate(placed)}
    colours = {name: LIGHT[i % 4] for i, name in enumerate(by_name)}
    for box in placed:
        for place, entry in enumerate(box.inputs, start=1):
            source = entry.source.partition(".")[0]
            if source not in by_name:
                continue
            side = 1 if order[source] < order[box.name] else -1
            edge = wide if side > 0 else 0.0
            lane = edge + side * _LANE * lanes[side, source]
            begin, end = by_name[source].row(0), box.row(place)
            style = {"color": colours[source], "linewidth": 1.2, "linestyle": "-" if side > 0 else "--"}
            axis.plot([edge, lane, lane], [begin, begin, end], **style)
            arrow = {"arrowstyle": "-|>", "color": colours[source], "linewidth": 1.2}
            axis.annotate("", xy=(edge, end), xytext=(lane, end), arrowprops=arrow)
