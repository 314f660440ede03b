"""Where the foreign material is, and the FMUs that are built from it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

DEFAULT = Path(__file__).parents[3] / "shared" / "foreign"
FOLDER = Path(os.environ.get("DOCKLOOP_FOREIGN", DEFAULT))


def build_reference_fmus(target: Path) -> dict[str, Path]:
    """Build the Reference FMUs; FMI version to the folder that holds them."""
    built = {}
    for version in ("2.0", "3.0"):
        folder = target / f"reference-{version[0]}"
        configure = ["cmake", "-S", FOLDER / "reference-fmus", "-B", folder]
        _call(*configure, f"-DFMI_VERSION={version[0]}", "-DCMAKE_BUILD_TYPE=Release")
        _call("cmake", "--build", folder, "-j", "2")
        built[version] = folder / "fmus"
    return built


def build_pythonfmu3(name: str, target: Path) -> Path:
    """Build one of PythonFMU3's examples."""
    target.mkdir(parents=True, exist_ok=True)
    script = target / f"{name}.py"
    shutil.copyfile(FOLDER / "pythonfmu3" / script.name, script)
    build = (
        "import sys; from pythonfmu3.builder import FmuBuilder; "
        "FmuBuilder.build_FMU(sys.argv[1], dest=sys.argv[2])"
    )
    before = set(target.glob("*.fmu"))
    _call(sys.executable, "-c", build, script, target)
    [made] = set(target.glob("*.fmu")) - before
    return made


def pack_ssp(case: Path, fmus: Path, more: dict[str, str], target: Path) -> Path:
    """Pack a case of `ssp/cases` with the Reference FMUs of one FMI version; `more` are entries by FMU."""
    text = (case / "SystemStructure.ssd").read_text(encoding="utf-8")
    entries = {f"resources/{p.name}": p for p in fmus.glob("*.fmu") if f"resources/{p.name}" in text}
    entries |= {entry: fmus / f"{name}.fmu" for entry, name in more.items()}
    path = target / f"{case.name}.ssp"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(case.rglob("*")):
            if file.is_file() and file.name != "expected.json":
                archive.write(file, file.relative_to(case).as_posix())
        for entry, fmu in sorted(entries.items()):
            archive.write(fmu, entry)
    return path


def _call(*command: str | Path) -> None:
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(
            f"{command[0]}: exit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        )
