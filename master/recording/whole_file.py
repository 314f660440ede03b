"""Files that no reader sees half written."""

from __future__ import annotations

import tempfile
from pathlib import Path


def write_whole(path: Path, content: str | bytes) -> None:
    """
    Write a file in one move; its folder is made where it is missing.

    Raises:
        OSError: If it cannot be written; what was at `path` before is there still, and nothing else.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".partial", delete=False) as partial:
        written = Path(partial.name)
    try:
        written.write_bytes(content.encode() if isinstance(content, str) else content)
        written.chmod(0o644)
        written.replace(path)
    except BaseException:
        written.unlink(missing_ok=True)
        raise
