"""The page and the licence inside a fused FMU."""

from __future__ import annotations

from html import escape

from fmu_sources.export.places import licence

from .layout import Fused

_PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{name}</title>
<style>
body {{ font: 15px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }}
table {{ border-collapse: collapse; }}
th, td {{ text-align: left; padding: 0.2rem 0.8rem 0.2rem 0; border-bottom: 1px solid #ddd; }}
</style>
</head>
<body>
<h1>{name}</h1>
<p>{description}</p>
<p>A coupled system as one FMU: it takes steps of {step} s, or of any integer number of them.</p>
<p>Order of stepping: {order}</p>
<h2>FMUs</h2>
<table>
<tr><th>instance</th><th>model</th><th>steps every</th></tr>
{fmus}
</table>
<h2>Connections</h2>
<table>
<tr><th>from</th><th>to</th><th>delay (steps)</th></tr>
{wires}
</table>
</body>
</html>
"""


def documentation_files(fused: Fused) -> dict[str, bytes]:
    """Path in the FMU to content."""
    fmus = [
        (name, inner.description.model_name, f"{fused.schedule.every[name]} steps")
        for name, inner in fused.inners.items()
    ]
    wires = [(w.source.name, w.target.name, str(w.delay)) for w in fused.system.wires]
    page = _PAGE.format(
        name=escape(fused.name),
        description=escape(fused.description),
        step=repr(fused.grid.step_size),
        order=escape("; ".join(map(str, fused.schedule.groups))),
        fmus=_rows(fmus),
        wires=_rows(wires),
    )
    return {
        "documentation/index.html": page.encode(),
        "documentation/licenses/license.txt": licence(),
    }


def _rows(rows: list[tuple[str, str, str]]) -> str:
    cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    return "\n".join(f"<tr>{row}</tr>" for row in cells)
