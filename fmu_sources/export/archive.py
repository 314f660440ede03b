"""FMU archives whose bytes hang on their contents only."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

_DATE = (2026, 1, 1, 0, 0, 0)
_REGULAR_FILE_644 = 0o100644 << 16


def pack(contents: Mapping[str, bytes]) -> bytes:
    """Zip files (path in the archive, with `/`, to bytes), sorted, with one fixed date."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(contents, key=lambda p: (p != "modelDescription.xml", p)):
            info = zipfile.ZipInfo(path, _DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = _REGULAR_FILE_644
            archive.writestr(info, contents[path], compresslevel=9)
    return buffer.getvalue()
