"""The figures as data: which there are, and what their captions say."""

from __future__ import annotations

import pytest

from master.reproduce.figures.registry import FIGURES, PAPER


def test_every_figure_of_results_is_there():
    assert [f.id for f in PAPER] == [str(n) for n in (*range(10, 23), *range(24, 29))]


@pytest.mark.parametrize("figure", FIGURES, ids=lambda f: f.id)
def test_a_caption_says_what_the_paper_shows_and_what_ours_shows(figure):
    assert figure.title
    assert figure.paper
    assert figure.ours
