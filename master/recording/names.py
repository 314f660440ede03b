"""Names of folders for results: any text becomes one readable folder name, different texts different ones."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

_PLAIN = re.compile(r"\w[\w .,+=-]*", re.ASCII)
_LONGEST = 80
_RESERVED = {"con", "prn", "aux", "nul", *(f"{name}{i}" for name in ("com", "lpt") for i in range(1, 10))}

PLAIN_RUN = "default"


def folder_name(text: str) -> str:
    """Return a text itself where it can name a folder on any system, else a readable part and a digest."""
    is_plain = _PLAIN.fullmatch(text) and len(text) <= _LONGEST and not text.endswith((" ", "."))
    if is_plain and text.partition(".")[0].lower() not in _RESERVED:
        return text
    readable = re.sub(r"[^\w,+=-]+", "_", text, flags=re.ASCII).strip("_")[: _LONGEST - 9]
    digest = hashlib.sha256(text.encode("utf-8", errors="surrogatepass")).hexdigest()[:8]
    return f"{readable}-{digest}".lstrip("-")


def results_folder(name: str, variant: str | None, assignments: Iterable[str]) -> Path:
    """
    Return the folder of a run: `results/<name>/<variant>`, `default` without a variant.

    Assignments follow the variant, the last one for each variable, in alphabetical order.
    """
    if variant == PLAIN_RUN:
        variant = f"variant {PLAIN_RUN}"
    parts = [PLAIN_RUN if variant is None else variant]
    last = {a.partition("=")[0]: a for a in assignments}
    parts += [last[signal] for signal in sorted(last)]
    return Path("results") / folder_name(name) / folder_name(",".join(parts))
