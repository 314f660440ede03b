"""Every kind of page that dockloop writes, by its own writer: no fault in a real browser, by axe-core too."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.comparison.compare import Score
from master.comparison.page import write_page as write_comparison
from master.diagnosis.answer.report.page import page as diagnosis_page
from master.diagnosis.answer.report.panels import Panel
from master.pages.chart import Chart, Curve, Region
from master.pages.picture import save
from master.reproduce.figures.registry import FIGURES
from master.reproduce.page import write_page as write_reproduction
from tests.master.diagnosis.answer.made_up_report import UNITS, made_up_report
from tests.master.pages.made_up_charts import charts, motions
from tests.master.reproduce.made_up_content import made_up_content
from tests.systems.page_checks import faults

pytestmark = pytest.mark.long

SCENARIO = """
limits: {contact.f_act: 400}
events:
  - {at: 0.1, offset: {force_sensor.f_act: 1.0}, for: 0.01}
  - {when: contact.f_act < 200, offset: {force_sensor.f_act: 1.0}}
"""


def runs(folder: Path) -> list[Path]:
    config = Path(__file__).parents[2] / "configs" / "low_frequency.yaml"
    system = folder / "system.yaml"
    system.write_text(config.read_text(encoding="utf-8") + SCENARIO, encoding="utf-8")
    first = folder / "first"
    command = ["run", str(system), "--stop-time", "0.3", "--page"]
    done = [
        CliRunner().invoke(main, [*command, "--output", str(first)]),
        CliRunner().invoke(
            main, [*command, "--output", str(folder / "second"), "--set", "spacecraft.m_s=900"]
        ),
    ]
    assert [one.exit_code for one in done] == [0, 0], done[0].output + done[1].output
    overlay = folder / "overlay.html"
    compared = ["compare", str(first), str(folder / "second"), "--output", str(overlay)]
    assert CliRunner().invoke(main, compared).exit_code == 1
    return [first / "run.html", overlay]


def comparison(folder: Path) -> list[Path]:
    errors = (0.05, 0.3, 1.0, 5.0, 20.0, None)
    methods = ("none", "smith_predictor", "cfdc_dpdc", "robust", "adaptive", "feedforward")
    scores = [
        Score("experiment_1000kg", cell, method, error, error, "completed" if error else "diverged")
        for cell in ("nominal", "k_m=150000")
        for method, error in zip(methods, errors, strict=True)
    ]
    page = folder / "methods.html"
    write_comparison(scores, 3, page)
    return [page]


def reproduction(folder: Path) -> list[Path]:
    page = folder / "reproduction.html"
    x, y = np.array([0.0, 0.1, 0.2, 0.1, 0.0]), np.array([-10.0, 0.0, 10.0, 5.0, -10.0])
    regions = [Region(x, y, "#2f7fb850"), Region(x, y, label="0.1"), Region(x, y, is_bold=True)]
    chart = replace(motions(2, 200), regions=regions)
    write_reproduction(made_up_content({f.id: [chart] for f in FIGURES}), page)
    return [page]


def diagnosis(folder: Path) -> list[Path]:
    t = np.arange(300) * 1e-3
    pictures = [
        save(
            "what is left",
            [Chart("", "time [s]", "force [N]", [Curve("after", t, np.sin(t))])],
            folder / name,
        )
        for name in ("axis_sealed.png", "axis_where.png")
    ]
    panels = [
        Panel("axis", pictures[0], "Measured and simulated on the sealed rows.", charts()),
        Panel("axis", pictures[1], "What the residual correlates with."),
    ]
    page = folder / "report.html"
    page.write_text(diagnosis_page(made_up_report(), panels, UNITS), encoding="utf-8")
    return [page]


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    made = [page for make in (runs, comparison, reproduction, diagnosis) for page in make(folder)]
    return {page.stem: page for page in made}


@pytest.mark.parametrize("name", ["run", "overlay", "methods", "reproduction", "report"])
def test_a_page_has_no_fault_in_any_view(browser, pages, name):
    assert faults(browser, pages[name]) == []


def test_the_checks_see_the_faults_of_a_bad_page(browser, tmp_path):
    page = tmp_path / "bad.html"
    page.write_text(
        "<!DOCTYPE html><title>bad</title><body style='background: #eee'><main>"
        "<p style='width: 900px'>wide</p><p style='width: 4px; overflow-wrap: anywhere'>letters</p>"
        "<img src='data:,'><p style='color: #ddd'>pale</p><button style='outline: none'>b</button></main>",
        encoding="utf-8",
    )
    found = json.dumps(faults(browser, page))

    for said in (
        "scrolls sideways",
        "split over lines: letters",
        "image-alt",
        "color-contrast",
        "html-has-lang",
    ):
        assert said in found
    for said in ("no outline", "printed on rgb(238", "1 pictures are not seen"):
        assert said in found
