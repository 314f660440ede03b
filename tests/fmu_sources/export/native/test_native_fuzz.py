"""Random FMI call sequences, legal and illegal, under the address and undefined-behaviour sanitizers."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from fmu_sources.composed import registry
from fmu_sources.export import native
from tests.costs import long_for
from tests.fmu_sources.export.native.native_library import GUID
from tests.fmu_sources.export.native.native_model import MODEL

HOST = Path(__file__).with_name("host_fuzz.c")
FLAGS = (
    "-std=c11",
    "-g",
    "-O1",
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-Wall",
    "-Wextra",
    "-Werror",
)

NAMES = [*registry.model_files(), "specimen"]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc with its sanitizers")
@pytest.mark.parametrize("name", long_for(NAMES[3:], NAMES))
def test_200_random_call_sequences_find_no_fault(tmp_path: Path, name: str) -> None:
    model = MODEL if name == "specimen" else registry.load(name)
    for file, content in native.generate(model, GUID).items():
        (tmp_path / file).write_bytes(content)
    files = [*sorted(str(path) for path in tmp_path.glob("*.c")), str(HOST)]
    subprocess.run(
        ["gcc", *FLAGS, "-I", str(tmp_path), *files, "-lm", "-pthread", "-o", "host"],
        cwd=tmp_path,
        check=True,
    )

    done = subprocess.run(["./host", "200"], cwd=tmp_path, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("200 sequences, ")

    words = ["./host", "20", "7", "2"]
    both = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert both.returncode == 0, both.stdout + both.stderr
    assert both.stdout.startswith("40 sequences, 9600 calls, ")
