"""
Pages of the site that are executed when it is built: notebooks, and the gallery with its pictures.

MkDocs calls `on_files` (`hooks` in `mkdocs.yml`). A cell or a command that fails ends the build. Notebooks
are kept without outputs: what they show is made by the code that the site describes, and nobody has to read
pictures in a change.
"""

from __future__ import annotations

import base64
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
NOTEBOOKS = DOCS / "notebooks"
GALLERY = DOCS / "gallery.md"
_COMMANDS = re.compile(r"^```sh\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_SHOWN = re.compile(r"\]\((gallery/[^)]+)\)")
_PATIENCE = 600  # s for a cell, and for the kernel to start: a machine that builds may be busy


def on_files(files: Any, config: Any) -> Any:
    """Add what is made to the files of the folder."""
    from mkdocs.structure.files import File

    for path, content in made().items():
        files.append(File.generated(config, path, content=content))
    return files


def made() -> dict[str, str | bytes]:
    """Execute all; return texts of pages and bytes of pictures by their path in the site."""
    found: dict[str, str | bytes] = {}
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        found |= notebook_page(path)
    return found | gallery_files()


def gallery_files() -> dict[str, str | bytes]:
    """Run the commands of the gallery's page; return the files that it shows."""
    text = GALLERY.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        for block in _COMMANDS.findall(text):
            for line in block.splitlines():
                program, *words = shlex.split(line)
                assert program == "dockloop", line
                command = [sys.executable, "-m", "master", *words]
                done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
                if done.returncode:
                    raise RuntimeError(f"{GALLERY.name}: {line}: {done.stdout}{done.stderr}")
        return {shown: (Path(folder) / shown).read_bytes() for shown in _SHOWN.findall(text)}


def notebook_page(path: Path) -> dict[str, str | bytes]:
    """Execute a notebook in an empty folder; return it as a page, and its pictures."""
    notebook = executed(path)
    parts = [f"*This page is the notebook [{path.name}]({path.name}), executed when the site was built.*"]
    files: dict[str, str | bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            picture = output.get("data", {}).get("image/png")
            if picture is None:
                parts += _text_of(output)
                continue
            name = f"{path.stem}_{len(files) + 1}.png"
            files[f"notebooks/{name}"] = base64.b64decode(picture)
            parts.append(f"![Picture made by the cell above]({name})")
    title = next(i for i, part in enumerate(parts) if part.startswith("# "))
    parts.insert(title, parts.pop(0))
    return {f"notebooks/{path.stem}.md": "\n\n".join(parts) + "\n", **files}


def executed(path: Path) -> Any:
    """Return a notebook with its outputs; raises at the first cell that fails."""
    import nbformat
    from nbclient import NotebookClient
    from traitlets.config import Config

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as sockets:
        place = {"metadata": {"path": folder}}
        connection = {"transport": "ipc", "ip": f"{sockets}/kernel"}  # no ports that others could talk to
        settings = Config({"ConnectionFileMixin": connection})
        client = NotebookClient(
            notebook,
            timeout=_PATIENCE,
            startup_timeout=_PATIENCE,
            kernel_name="python3",
            resources=place,
            config=settings,
            coalesce_streams=True,
        )
        return client.execute()


def _text_of(output: Mapping[str, Any]) -> Iterator[str]:
    """What an output says: HTML where there is some, else text; warnings too."""
    data = output.get("data", {})
    if "text/html" in data:
        yield f'<div class="output">{data["text/html"]}</div>'
        return
    text = output.get("text") or data.get("text/plain") or ""
    if text.strip():
        yield f"```text\n{text.rstrip()}\n```"
