"""The paper, reproduced whole: every row as it was found, every figure, and the page in a browser."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from master.cli import main
from master.reproduce.figures.registry import FIGURES
from master.reproduce.reproduction import CLAIMS
from tests.systems.page_checks import faults

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduced")
    result = CliRunner().invoke(main, ["reproduce", "--output", str(folder), "--json"])
    assert result.exit_code == 0, result.output
    return SimpleNamespace(folder=folder, **json.loads(result.stdout))


def test_every_row_is_judged_as_it_was_found(reproduced):
    assert [row["id"] for row in reproduced.claims] == [f"{c.id}.{k.id}" for c in CLAIMS for k in c.checks]
    assert reproduced.changed == []
    assert all(row["seeds"] >= 10 for row in reproduced.claims)


def test_a_row_has_its_keys(reproduced):
    keys = {"id", "place", "claim", "bound", "bound_from", "measured", "seeds", "noise", "verdict", "why"}

    assert all(set(row) == keys for row in reproduced.claims)
    assert all(row["bound_from"] and row["noise"] for row in reproduced.claims)


def test_every_figure_is_a_png_file_too(reproduced):
    for figure in FIGURES:
        assert Path(reproduced.files["figures"][figure.id]).read_bytes().startswith(b"\x89PNG")


@pytest.fixture(scope="module")
def browser(browser, reproduced):
    browser.log()  # of pages before this one
    browser.show(Path(reproduced.files["page"]))
    return browser


def test_the_page_loads_without_an_error(browser):
    assert browser.run("return document.body.dataset.ready") == "true"
    assert [entry for entry in browser.log() if entry["level"] == "SEVERE"] == []


def test_every_figure_is_drawn(browser):
    drawn = browser.run(
        "return Object.fromEntries([...document.querySelectorAll('figure')].map(f => [f.dataset.figure, "
        "[...f.querySelectorAll('canvas')].map(c => { const g = c.getContext('2d'); const d = "
        "g.getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 0; i < d.length; i += 4) "
        "if (d[i + 3] && Math.abs(d[i] - d[i + 1]) + Math.abs(d[i + 1] - d[i + 2]) > 60) n++; "
        "return n; })]))"
    )

    assert list(drawn) == [f.id for f in FIGURES]
    for figure, coloured in drawn.items():
        assert coloured, figure
        assert min(coloured) > 100, figure


def test_the_page_is_legible_at_1280_pixels(browser):
    sizes = browser.run(
        "return [...document.querySelectorAll('p, td, th, figcaption, .labels button')]"
        ".map(e => parseFloat(getComputedStyle(e).fontSize))"
    )
    wide = browser.run("return [document.documentElement.scrollWidth, window.innerWidth]")
    outside = browser.run(
        "return [...document.querySelectorAll('td, th, .labels, canvas')].filter(e => "
        "e.getBoundingClientRect().right > window.innerWidth + 1).length"
    )

    assert min(sizes) >= 13.0
    assert wide == [1280, 1280]
    assert outside == 0


def test_the_page_has_no_fault_in_any_view(browser, reproduced):
    assert faults(browser, Path(reproduced.files["page"])) == []


def test_a_click_on_a_label_hides_its_curve(browser, reproduced):
    browser.show(Path(reproduced.files["page"]))
    pressed = browser.run(
        "const b = document.querySelector('.labels button'); b.click(); return b.getAttribute('aria-pressed')"
    )

    assert pressed == "false"


def test_the_page_names_no_folder_of_this_machine(reproduced):
    text = Path(reproduced.files["page"]).read_text(encoding="utf-8")

    assert re.findall(r"/(?:home|root|tmp)/\w+", text) == []
