"""JSON Schemas: the shipped ones are those of the code, and every shipped file keeps them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from master.cli import main

jsonschema = pytest.importorskip("jsonschema")

CONFIGS = Path(__file__).parents[3] / "configs"
FILES = sorted(CONFIGS.rglob("*.yaml"))


def kind_of(path):
    folders = {"measured": "case", "campaigns": "campaign"}
    return next((kind for folder, kind in folders.items() if folder in path.parts), "system")


@pytest.mark.parametrize("kind", ["system", "case", "campaign"])
def test_the_shipped_schema_is_what_the_command_prints(kind):
    printed = CliRunner().invoke(main, ["schema", kind]).stdout

    assert (CONFIGS / "schema" / f"{kind}.json").read_text(encoding="utf-8") == printed


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(CONFIGS).as_posix())
def test_a_shipped_file_names_its_schema_and_keeps_it(path):
    text = path.read_text(encoding="utf-8")
    named = text.partition("\n")[0].partition("$schema=")[2]
    schema = (path.parent / named).resolve()
    content = json.loads(schema.read_text(encoding="utf-8"))

    assert schema == CONFIGS / "schema" / f"{kind_of(path)}.json"
    jsonschema.Draft202012Validator(content).validate(yaml.safe_load(text))


@pytest.mark.parametrize(
    "change",
    [
        {"colour": "red"},
        {"stop_time": "soon"},
        {"connections": [{"from": "a.b"}]},
        {"fmus": {}},
    ],
)
def test_a_wrong_system_breaks_the_schema(change):
    good = yaml.safe_load((CONFIGS / "low_frequency.yaml").read_text(encoding="utf-8"))
    schema = json.loads((CONFIGS / "schema" / "system.json").read_text(encoding="utf-8"))
    validator = jsonschema.Draft202012Validator(schema)

    assert validator.is_valid(good)
    assert validator.is_valid(good | {"events": None})
    assert not validator.is_valid(good | change)


def test_the_schema_of_a_report_is_one_and_sees_a_wrong_verdict_and_a_missing_key():
    schema = json.loads(CliRunner().invoke(main, ["schema", "report"]).stdout)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    said = [e.message for e in validator.iter_errors({"verdict": "fine", "sentence": 3})]

    assert any("'fine' is not one of" in text for text in said)
    assert any("3 is not of type 'string'" in text for text in said)
    assert any("'effects' is a required property" in text for text in said)
