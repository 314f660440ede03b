"""`python -m tests.conformance`: run every case, print the table; --docs writes it to the documents."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from .cases import Case, Finding, all_cases
from .material import FOLDER, build_reference_fmus

PAGE = Path(__file__).parents[2] / "docs" / "conformance.md"

HEAD = """\
# Conformance

FMUs and systems of others, run by `dockloop run` and compared with what their authors published:
the [Reference FMUs](https://github.com/modelica/Reference-FMUs) of the Modelica Association, MasterSim's
control loop, PythonFMU3's examples, and SSP 1.0 archives. The relative difference is at most 1e-9.
`refused` means: rightly so, with exit status 2 and a message that names the reason. Made by
`python -m tests.conformance --docs`; the tests run the same cases (`tests/conformance`), and need the
sources of others in the folder that `DOCKLOOP_FOREIGN` names.

| from | case | FMI | result | remark |
|---|---|---|---|---|
"""


def row(case: Case, finding: Finding) -> str:
    remark = finding.remark.replace("|", "\\|")
    return f"| {case.group} | {case.name} | {case.fmi} | {finding.status} | {remark} |\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", action="store_true", help=f"write the table to docs/{PAGE.name}")
    to_docs = parser.parse_args().docs
    if not FOLDER.is_dir():
        parser.error(f"DOCKLOOP_FOREIGN: no such folder, got {FOLDER}, expected the foreign material")
    rows, wrong = [], 0
    with tempfile.TemporaryDirectory() as scratch:
        fmus = build_reference_fmus(Path(scratch))
        for i, case in enumerate(all_cases()):
            folder = Path(scratch) / f"case{i}"
            folder.mkdir()
            finding = case.judge(fmus, folder)
            wrong += not finding.is_right
            rows.append(row(case, finding))
            print(rows[-1], end="", flush=True)
    if to_docs:
        PAGE.write_text(HEAD + "".join(rows), encoding="utf-8")
    return min(wrong, 1)


if __name__ == "__main__":
    raise SystemExit(main())
