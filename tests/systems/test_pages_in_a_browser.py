"""Pages with charts of made-up signals in a browser: on a desk, a phone, paper, dark, without scripts."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from master.pages.chart import Chart, Curve
from master.pages.render import render
from tests.master.pages.made_up_charts import charts

TEMPLATE = """{% extends "base.html.j2" %}{% from "parts.html.j2" import plots, table %}
{% block title %}charts{% endblock %}{% block body %}<h1>Charts</h1>
{{ plots("all", charts["all"]) }}
{{ table(("name", "a heading of several words", "value"), rows, (2,)) }}{% endblock %}"""
COLOURED = """return [...document.querySelectorAll('canvas')].map(c => {
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0;
  for (let i = 0; i < d.length; i += 4) {
    const [low, high] = [Math.min(d[i], d[i+1], d[i+2]), Math.max(d[i], d[i+1], d[i+2])];
    if (d[i + 3] > 128 && high - low > 60) n++;
  }
  return n; })"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def page(folder) -> Path:
    file = folder / "page.html"
    rows = [("motion_simulator.a_rather_long_name_of_a_signal", "words " * 20, "1.234e-05")] * 3
    file.write_text(rendered(folder, {"all": charts()}, rows), encoding="utf-8")
    return file


def rendered(folder, named, rows=()):
    package = folder / "page_package"
    (package / "templates").mkdir(parents=True, exist_ok=True)
    (package / "__init__.py").touch()
    (package / "templates" / "page.html.j2").write_text(TEMPLATE, encoding="utf-8")
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    return render("page_package", "page.html.j2", charts=named, rows=rows)


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("dark", [False, True])
def test_a_page_fits_its_window_and_draws_every_chart(browser, page, width, dark):
    browser.show(page, width, dark)

    assert browser.run("return document.body.dataset.ready") == "true"
    assert browser.run("return document.documentElement.scrollWidth") == width
    drawn = browser.run(COLOURED)
    assert len(drawn) == 3
    assert min(drawn) > 60
    assert browser.run("return document.querySelectorAll('.picture').length") == 3
    assert shown(browser, ".picture") == [False] * 3
    assert [entry for entry in browser.log() if entry["level"] == "SEVERE"] == []


def shown(browser, selector):
    return browser.run(
        f"return [...document.querySelectorAll('{selector}')].map(e => e.offsetParent !== null)"
    )


@pytest.mark.parametrize(("dark", "page_colour"), [(False, "rgb(255, 255, 255)"), (True, "rgb(20, 24, 29)")])
def test_a_page_has_the_theme_of_its_reader(browser, page, dark, page_colour):
    browser.show(page, dark=dark)

    assert browser.run("return getComputedStyle(document.body).backgroundColor") == page_colour


def test_paper_gets_the_pictures(browser, page):
    browser.show(page, medium="print", dark=True)

    assert shown(browser, ".picture") == [True] * 3
    assert shown(browser, ".field") == [False] * 3
    assert browser.run("return getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


def test_without_scripts_a_page_shows_its_pictures(browser, page):
    browser.scripts(run=False)
    try:
        browser.show(page, 390)
        assert browser.run("return document.body.dataset.ready") is None
        assert shown(browser, ".picture") == [True] * 3
        assert min(browser.run("return [...document.images].map(i => i.naturalWidth)")) > 300
        assert browser.run("return document.documentElement.scrollWidth") == 390
    finally:
        browser.scripts(run=True)


def test_long_numbers_leave_room_for_the_label_of_their_axis(folder, browser):
    """Numbers of six characters are some 46 px wide, their ticks 13, the label of the axis 20."""
    file = folder / "long_numbers.html"
    t = np.linspace(0.0, 1.0, 50)
    both = [
        Chart("force", "time [s]", "force [N]", [Curve("f", t, size * np.sin(9.0 * t))])
        for size in (1.0, 3e4)
    ]
    file.write_text(rendered(folder, {"all": both}), encoding="utf-8")
    browser.show(file, 1280, False)
    short, long = browser.run("return [...document.querySelectorAll('.u-over')].map(e => e.offsetLeft)")

    assert short < 46 + 13 + 20 <= long


def test_arrow_keys_read_values(browser, page):
    browser.show(page)
    script = """const field = document.querySelector('.field'); field.focus();
    field.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight'}));
    await new Promise(r => setTimeout(r, 100));
    const plot = field.closest('.plot');
    const values = [...plot.querySelectorAll('output')].map(o => o.value);
    return [plot.querySelector('.at').textContent, ...values];"""
    at, ideal, first, *_ = browser.run(f"return (async () => {{ {script} }})()")

    assert at == "time [s]: 5"  # the middle first; by hand: 10 cos 30 = 1.54251
    assert float(ideal) == pytest.approx(1.54251, abs=1e-5)
    assert float(first) == pytest.approx(1.54, abs=0.25)


def test_a_click_on_a_label_hides_its_curve(browser, page):
    browser.show(page)
    before = browser.run(COLOURED)[0]
    script = """const b = document.querySelectorAll('.labels button')[1]; b.click();
    await new Promise(r => setTimeout(r, 100)); return b.getAttribute('aria-pressed');"""

    assert browser.run(f"return (async () => {{ {script} }})()") == "false"
    assert browser.run(COLOURED)[0] < before


def test_a_run_of_20_signals_is_a_page_of_at_most_2500_kilobytes(folder, browser):
    t = np.arange(10_001) * 1e-3
    noise = np.random.default_rng(1)
    signals = [
        Chart(
            f"signal {i}", "time [s]", "force [N]", [Curve(f"signal {i}", t, noise.standard_normal(len(t)))]
        )
        for i in range(20)
    ]
    file = folder / "run.html"
    file.write_text(rendered(folder, {"all": signals}), encoding="utf-8")

    assert file.stat().st_size <= 2_500_000
    browser.show(file)
    assert len(browser.run(COLOURED)) == 20
