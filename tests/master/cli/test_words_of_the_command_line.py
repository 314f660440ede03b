"""Words of the command line that are refused are shown, and control nothing."""

import pytest
from click.testing import CliRunner

from master.cli import main


@pytest.mark.parametrize(
    "words",
    [
        ["check", "a", "\x1b[2J"],
        ["\x1b[2J"],
        ["--\x1b[2J"],
        ["check", "--\x1b[2J", "a"],
        ["run", "a", "--stop-time", "\x1b[2J"],
        ["check", "a", "--flavour", "\x1b[2J"],
    ],
)
def test_a_word_that_is_refused_reaches_the_terminal_as_an_escape(words):
    done = CliRunner().invoke(main, words)

    assert done.exit_code == 2
    assert "\\x1b[2J" in done.stderr
    assert "\x1b" not in done.stderr
