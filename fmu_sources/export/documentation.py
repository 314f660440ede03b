"""What an FMU says to people: documentation/index.html, the licence and the icon."""

from __future__ import annotations

import inspect
import sys
from html import escape

from ..composed.composition import Composed
from ..framework.model import Model
from ..framework.variables import Role, Variable
from .facts import causality, fmi_variables
from .icon import icon_png
from .places import licence

_PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{name}</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }}
pre {{ background: #f4f5f7; padding: 1rem; white-space: pre-wrap; overflow-wrap: anywhere; }}
table {{ border-collapse: collapse; }}
th, td {{ text-align: left; vertical-align: top; padding: 0.2rem 0.8rem 0.2rem 0; }}
th, td {{ border-bottom: 1px solid #ddd; }}
</style>
</head>
<body>
<h1>{name}</h1>
<p>{description}</p>
<pre>{equations}</pre>
{tables}
</body>
</html>
"""

_TITLES = {Role.PARAMETER: "Parameters", Role.INPUT: "Inputs", Role.STATE: "States", Role.OUTPUT: "Outputs"}


def documentation_files(model: Model) -> dict[str, bytes]:
    """Path in the FMU to content."""
    return {
        "documentation/index.html": _page(model).encode(),
        "documentation/licenses/license.txt": licence(),
        "model.png": icon_png(model.name),
    }


def _page(model: Model) -> str:
    tables = "\n".join(_table(model, role) for role in Role if any(_shown(model, role)))
    return _PAGE.format(
        name=escape(model.name),
        description=escape(model.description),
        equations=escape("\n\n".join(_texts(model))),
        tables=tables,
    )


def _texts(model: Model) -> list[str]:
    """Docstrings of the module of a model and of the effects in it."""
    texts = [inspect.getdoc(sys.modules[type(model).__module__]) or ""]
    for place in model.placed if isinstance(model, Composed) else ():
        law = inspect.getdoc(sys.modules[place.effect.law.__module__]) or ""
        texts.append(f"{place.effect.name} in {place.slot.name}\n\n{law}")
    return texts


def _shown(model: Model, role: Role) -> list[Variable]:
    return [v for _, v in fmi_variables(model) if v.role is role]


def _table(model: Model, role: Role) -> str:
    rows = "\n".join(_row(v) for v in _shown(model, role))
    head = "<tr><th>name</th><th>unit</th><th>start</th><th>causality</th><th>meaning</th></tr>"
    return f"<h2>{_TITLES[role]}</h2>\n<table>\n{head}\n{rows}\n</table>"


def _row(v: Variable) -> str:
    start = next((f"{i.value} ({i.name})" for i in v.items or () if i == v.start), str(v.start))
    items = "; ".join(f"{i.value} {i.name}" for i in v.items or ())
    meaning = f"{v.description}: {items}" if items else v.description
    cells = (v.name, v.unit, start, causality(v), meaning)
    return "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in cells) + "</tr>"
