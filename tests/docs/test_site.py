"""The site: complete reference, tutorials that run as they are, pages that work from disk."""

from __future__ import annotations

import html
import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import dockloop
from fmu_sources.composed import registry
from fmu_sources.effects import catalogue
from master.cli import COMMANDS
from master.diagnosis.case.case import Case
from master.system.config import Config
from tests.docs.followed import blocks, follow

PROJECT = Path(__file__).parents[2]
DOCS = PROJECT / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
WORDS = ("slot", "sealed", "guard", "spread", "ceiling", "family", "gain", "round")


@pytest.fixture(scope="module")
def reference() -> dict[str, str]:
    spec = importlib.util.spec_from_file_location("reference", DOCS / "reference.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: dict[str, str] = module.pages()
    return found


def keys_of(model) -> set[str]:
    """Keys of a section and of all sections that its schema has."""
    schema = model.model_json_schema(by_alias=True)
    return {key for s in (schema, *schema["$defs"].values()) for key in s.get("properties", {})}


@pytest.mark.parametrize(("page", "model"), [("system", Config), ("case", Case)])
def test_every_key_of_a_file_has_its_row(reference, page, model):
    listed = set(re.findall(r"^\| `([^`]+)` \|", reference[f"reference/{page}.md"], re.MULTILINE))

    assert keys_of(model) - listed == set()


def test_every_command_name_model_and_effect_has_its_heading(reference):
    def headings(page):
        return set(re.findall(r"^##+ (\S+)$", reference[f"reference/{page}.md"], re.MULTILINE))

    assert set(COMMANDS) - headings("commands") == set()
    assert set(dockloop.__all__) - headings("python") == set()
    assert set(registry.model_files()) - headings("models") == set()
    assert set(catalogue.listed()) - headings("effects") == set()


def test_models_and_effects_have_their_texts_and_commands_their_options(reference):
    assert "m y'' = u - d y' - F" in reference["reference/models.md"]
    assert "F = value + F_c tanh(v / v_0)" in reference["reference/effects.md"]
    assert "--stop-time" in reference["reference/commands.md"]
    assert reference["reference/models.md"].count("Source") >= 10


@pytest.mark.parametrize("word", WORDS)
def test_the_glossary_has_the_word(word):
    assert f"\n### {word}\n" in (DOCS / "glossary.md").read_text(encoding="utf-8")


def test_nothing_cites_a_text_that_users_cannot_read():
    shown = [
        f
        for folder in ("master", "dockloop", "fmu_sources", "configs", "docs")
        for f in (PROJECT / folder).rglob("*")
    ]
    texts = [f for f in shown if f.suffix in (".py", ".md", ".yaml", ".j2") and f.is_file()]
    cited = {
        f.name
        for f in texts
        if re.search(r"physics\.md|\.\./shared|diagnosis2\.md", f.read_text(encoding="utf-8"))
    }

    assert len(texts) > 300
    assert cited == set()


def test_every_section_that_a_bound_cites_is_there():
    sections = re.findall(
        r"^## (.+)$", (DOCS / "bounds.md").read_text(encoding="utf-8").lower(), re.MULTILINE
    )
    code = "".join(
        f.read_text(encoding="utf-8") for f in (PROJECT / "master" / "reproduce" / "claims").glob("*.py")
    )
    cited = set(re.findall(r"(?<!criteria of )docs/bounds\.md, ([a-z -]+)", code))

    assert len(cited) >= 5
    assert [c for c in cited if not any(s.startswith(c.strip()) for s in sections)] == []


def test_every_tutorial_has_blocks_and_is_in_the_navigation():
    navigation = (PROJECT / "mkdocs.yml").read_text(encoding="utf-8")

    assert len(TUTORIALS) == 4
    for path in TUTORIALS:
        assert f"tutorials/{path.name}" in navigation
        assert len(blocks(path)) >= 2


@pytest.mark.long
def test_the_page_on_delays_runs_word_by_word_in_an_empty_folder(tmp_path):
    """The tutorials: `tests/installed/test_wheel.py`."""
    follow(DOCS / "delays.md", tmp_path)


def test_the_keys_of_the_page_on_isolation_are_those_of_a_system():
    [part] = re.findall(r"```yaml\n(.*?)```", (DOCS / "isolation.md").read_text(encoding="utf-8"), re.DOTALL)
    written = yaml.safe_load(part)
    read = Config.model_validate({"name": "a", "step_size": 0.01, "stop_time": 1.0, **written})

    assert read.fmus["wheel"].isolate is True
    assert (read.fmus["brake"].on_fault, read.fmus["brake"].deadline, read.fmus["brake"].memory) == (
        "hold",
        0.5,
        200,
    )


def test_every_page_is_in_the_navigation():
    navigation = (PROJECT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = [path.relative_to(DOCS) for path in DOCS.rglob("*.md")]
    pages += [path.relative_to(DOCS).with_suffix(".md") for path in DOCS.rglob("*.ipynb")]

    assert len(pages) >= 30
    assert [page for page in pages if f"- {page.as_posix()}\n" not in navigation] == []


def test_notebooks_are_kept_without_outputs_one_a_person():
    books = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in DOCS.rglob("*.ipynb")}
    code = {name: [c for c in book["cells"] if c["cell_type"] == "code"] for name, book in books.items()}

    assert set(books) == {path.stem for path in TUTORIALS}
    assert [name for name, cells in code.items() if len(cells) < 3] == []
    assert [
        name for name, cells in code.items() if any(c["outputs"] or c["execution_count"] for c in cells)
    ] == []


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The site, built: its notebooks and the commands of its gallery are executed."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    built = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=False, env=environment)

    assert built.returncode == 0, built.stderr
    assert built.stderr == ""
    return folder


@pytest.mark.long
def test_every_script_style_and_picture_of_the_site_is_on_the_disk(site):
    pages = {p.relative_to(site).as_posix(): p.read_text(encoding="utf-8") for p in site.rglob("*.html")}
    del pages["404.html"]  # for servers
    assert len(pages) >= 35
    for name, text in pages.items():
        for tag in re.findall(r"<(?:script|link|img)\b[^>]*>", text):
            target = re.search(r'(?:src|href)="([^"]*)"', tag)
            if target is None or "canonical" in tag or target[1].startswith("data:"):
                continue
            assert not re.match(r"https?:|//|/", target[1]), f"{name}: {tag}"
            file = (site / name).parent / html.unescape(target[1]).partition("?")[0].partition("#")[0]
            assert file.exists(), f"{name}: {tag}"


@pytest.mark.long
def test_the_gallery_has_the_pictures_that_its_commands_make(site):
    shown = re.findall(r"!\[[^]]+\]\(([^)]+)\)", (DOCS / "gallery.md").read_text(encoding="utf-8"))

    assert len(shown) >= 5
    assert all((site / picture).stat().st_size > 5000 for picture in shown)


@pytest.mark.long
@pytest.mark.parametrize("name", [path.stem for path in TUTORIALS])
def test_a_notebook_is_a_page_with_what_it_prints_and_draws(site, name):
    text = (site / "notebooks" / f"{name}.html").read_text(encoding="utf-8")

    assert re.search(rf'<img [^>]*src="{name}_1\.png"', text)
    assert 'class="output"' in text
    assert (site / "notebooks" / f"{name}.ipynb").exists()


@pytest.mark.long
def test_the_search_finds_pages_when_the_site_is_opened_from_disk(site, browser):
    browser.log()
    browser.show(site / "tutorials" / "run_a_system.html")
    script = """const field = document.querySelector('[data-md-component=search-query]');
    field.focus(); field.value = 'waveform'; field.dispatchEvent(new KeyboardEvent('keyup', {key: 'm'}));
    for (let i = 0; i < 600; i++) {
      const links = [...document.querySelectorAll('a.md-search-result__link')];
      if (links.length) return links.map(a => a.href);
      await new Promise(r => setTimeout(r, 100));
    }
    return [];"""
    found = browser.run(f"return (async () => {{ {script} }})()")

    assert any(Path(link.removeprefix("file://").partition("?")[0]).name == "coupling.html" for link in found)
    assert [entry["message"] for entry in browser.log() if entry["level"] == "SEVERE"] == []
