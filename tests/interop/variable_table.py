"""Write the compensator's variables, from its declarations, into the guide."""

from __future__ import annotations

import re
from pathlib import Path

from fmu_sources.composed import registry
from fmu_sources.export.facts import causality, fmi_variables, start_text, variability
from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Variable

GUIDE = Path(__file__).parents[2] / "docs" / "use_the_compensator_elsewhere.md"
BEGIN, END = "<!-- variables: begin -->", "<!-- variables: end -->"


def table(model: Model) -> str:
    """Give the variables as they stand in modelDescription.xml."""
    titles = ("reference", "name", "unit", "start", "causality", "variability", "meaning")
    head = "| " + " | ".join(titles) + " |\n" + "|---" * len(titles) + "|\n"
    return head + "".join(row(model, reference, v) for reference, v in fmi_variables(model))


def row(model: Model, reference: int, v: Variable) -> str:
    kind = causality(v)
    start = start_text(v) if kind in ("parameter", "input") else ""
    if v.items:
        start = ", ".join(f"{i.value} {i.name}" + (" (start)" if i == v.start else "") for i in v.items)
    unit = "" if v.unit == "1" else v.unit
    cells = (reference, f"`{v.name}`", unit, start, kind, variability(model, v), v.description)
    return "| " + " | ".join(map(str, cells)) + " |\n"


def with_table(guide: str) -> str:
    """Give the guide with the present table."""
    between = f"{BEGIN}\n\n{table(registry.load('compensator'))}\n{END}"
    return re.sub(f"{BEGIN}.*{END}", lambda _: between, guide, flags=re.DOTALL)


if __name__ == "__main__":
    GUIDE.write_text(with_table(GUIDE.read_text(encoding="utf-8")), encoding="utf-8")
