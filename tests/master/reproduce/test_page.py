"""The page from made-up content: all its parts are in one file that asks the network for nothing."""

from __future__ import annotations

import re

import pytest

from master.errors import ConfigError
from master.reproduce.facts.errata import ERRATA
from master.reproduce.figures.registry import FIGURES
from master.reproduce.page import write_page
from master.reproduce.reproduction import reproduce
from tests.master.reproduce.made_up_content import CHART, made_up_content


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    content = made_up_content({f.id: [CHART] for f in FIGURES})
    return write_page(content, tmp_path_factory.mktemp("page") / "index.html").read_text(encoding="utf-8")


def test_the_page_asks_the_network_for_nothing(page):
    assert re.findall(r"(?:src|href)\s*=\s*[\"'](?!#|data:)", page) == []
    assert re.findall(r"@import|url\(|fetch\(|XMLHttpRequest|WebSocket", page) == []


def test_every_figure_has_its_place(page):
    assert re.findall(r'data-figure="(\w+)"', page) == [f.id for f in FIGURES]


def test_text_of_the_data_does_not_end_the_script(page):
    assert page.count("</script>") == 3
    assert "&lt;/script&gt;" in page


def test_rows_show_case_bound_value_verdict_and_reason(page):
    assert (
        '<td>first case</td><td data-head="bound">zeta &gt; 0<br><span class="soft">a formula</span></td>'
        in page
    )
    assert '<td class="number" data-head="measured" title="worst of 10 seeds">0.25</td>' in page
    assert '<td class="number" data-head="measured" title="no noise">- \u25e6</td>' in page
    assert "It is &lt;stable&gt;" in page
    assert "maybe" in page


def test_every_erratum_is_listed(page):
    for erratum in ERRATA:
        assert erratum.place in page
    assert len(ERRATA) == 21


def test_only_the_figures_that_were_drawn_are_on_the_page(tmp_path):
    content = made_up_content({"10": [CHART]})
    page = write_page(content, tmp_path / "index.html").read_text(encoding="utf-8")

    assert re.findall(r'data-figure="([^"]*)"', page) == ["10"]


def test_what_is_neither_claim_nor_figure_is_refused_with_what_there_is(tmp_path):
    with pytest.raises(ConfigError) as caught:
        reproduce(tmp_path, lambda *_: lambda _: None, lambda _: None, ["ideaal", "10", "99"])

    first, second = caught.value.problems
    assert (first.got, second.got) == ("ideaal", "99")
    assert str(first.expected).startswith("'ideal'")
    assert list(tmp_path.iterdir()) == []
