"""Names in pictures that look like formulas."""

import pytest
from matplotlib.figure import Figure

from master.pages.plain_text import as_written

NAMES = ["a$\\frac{$", "b$x$", "$$"]


def with_categories(axes):
    axes.barh(NAMES, [1.0, 2.0, 3.0])


def with_ticks(axes):
    axes.set_yticks([0.0, 1.0, 2.0], NAMES)


def with_labels(axes):
    axes.set_xlabel(NAMES[0])
    axes.set_title(NAMES[1])
    axes.plot([1.0], label=NAMES[0])
    axes.figure.legend()


@pytest.mark.parametrize("write", [with_categories, with_ticks, with_labels])
def test_a_name_is_drawn_as_it_is_written_wherever_it_is(write, tmp_path):
    figure = Figure()
    write(figure.add_subplot())

    as_written(figure).savefig(tmp_path / "picture.png")

    assert (tmp_path / "picture.png").stat().st_size > 0
