"""A new effect is one file: nothing else is edited, and models, FMUs and searches have it."""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import fmu_sources
import master
from fmu_sources.effects.catalogue import listed
from fmu_sources.effects.framework.effect import EVERYWHERE, MECHANICAL, SIGNAL

PACKAGE = Path(fmu_sources.__file__).parent
FOLDER = PACKAGE / "effects"
PLACES = {MECHANICAL: "mechanical", SIGNAL: "signal", EVERYWHERE: "both"}

DAMPER = '''
"""F = value + d v."""

from ..framework.variables import parameter
from .framework.effect import MECHANICAL, Applied, Effect

EFFECT = Effect(
    name="more_damping",
    description="More damping",
    law=lambda t, value, s, x, p, m: Applied(value + p.damping * s.velocity),
    parameters=(parameter("damping", 0.0, "{value} s/{position}", "Damping d"),),
    absent={"damping": 0.0},
    scale=lambda rms: {"damping": 0.05 * rms.value / rms.velocity},
    needs=("velocity",),
    places=MECHANICAL,
)
'''

ASK = """
import json
from fmu_sources.composed.composition import all_slots
from fmu_sources.composed.registry import load, modules
from fmu_sources.effects.catalogue import candidates, effect
from fmu_sources.export.native import generate
from fmu_sources.export.python_flavour import python_sources

name = "docking_contact__guide_force_more_damping"
model = load(name)
print(json.dumps({
    "slots": [s.name for s in all_slots(model.base) if "more_damping" in [e.name for e in candidates(s)]],
    "amplitudes": effect("more_damping").amplitudes,
    "parameters": [v.name + " " + v.unit for v in model.variables if "more_damping" in v.name],
    "carried": [n for n in python_sources(*modules(name)) if "more_damping" in n],
    "native": b"guide_force_more_damping_damping" in generate(model, "")["model_variables.c"],
}))
"""


def test_one_file_is_a_candidate_a_model_and_an_fmu(tmp_path):
    copy = tmp_path / "fmu_sources"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "effects/more_damping.py").write_text(DAMPER, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", ASK], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr

    assert json.loads(done.stdout) == {
        "slots": ["rope_force", "guide_force", "manipulator_force"],
        "amplitudes": ["damping"],
        "parameters": ["guide_force_more_damping_damping N s/m"],
        "carried": ["effects/more_damping.py"],
        "native": True,
    }


def test_the_table_of_effects_names_each_once_with_its_needs_and_place():
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)\.py` \| .+ \| (.+) \| (mechanical|signal|both) \|$", text, re.MULTILINE)

    expected = [(n, ", ".join(e.needs) or "value", PLACES[e.places]) for n, e in listed().items()]
    assert [row for row in rows if row[0] != "learned"] == expected


WORDS = {"offset", "drift"}  # of other things too: a column's offset, a parameter that drifts


def test_no_other_file_knows_an_effect_by_its_name():
    found = []
    for root in (PACKAGE, Path(master.__file__).parent):
        for path in root.rglob("*.py"):
            if FOLDER not in path.parents:
                found += [(path.name, name) for name in names_in(path.read_text(encoding="utf-8"))]

    assert found == []


def names_in(source):
    """Names of effects that stand alone in a text of the source, or are imported."""
    names = set(listed())
    tree = ast.parse(source)
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    given = {id(a) for call in calls if is_about_effects(call) for a in call.args}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node.value in names - (set() if id(node) in given else WORDS):
            yield node.value
        if isinstance(node, ast.ImportFrom) and "effects" in (node.module or ""):
            yield from {*(node.module or "").split("."), *(alias.name for alias in node.names)} & names


def is_about_effects(call):
    return ast.unparse(call.func).rpartition(".")[2] in {"Added", "PlacedEffect", "effect", "with_effect"}
