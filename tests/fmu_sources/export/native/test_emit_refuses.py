"""An operation that has no C text is refused with what to write instead."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from master.cli import main

MODEL = """\
from fmu_sources.framework.model import Model, no_effect
from fmu_sources.framework.variables import declare, input_, state


class Cubed(Model):
    name = "cubed"
    description = "A power."
    variables = declare(input_("u", "1", "Input"), state("x", "1", "State", output=True))

    def derivatives(self, t, x, u, p, m, slot=no_effect):
        return {"x": u.u - x.x**2.5}


MODEL = Cubed()
"""


def test_a_power_in_a_model_of_ones_own_is_told_without_a_traceback(tmp_path):
    pytest.importorskip("casadi")
    file = tmp_path / "cubed.py"
    file.write_text(MODEL, encoding="utf-8")
    done = CliRunner().invoke(main, ["build", str(file), "--output", str(tmp_path)])

    assert done.exit_code == 2
    assert done.exception is None or isinstance(done.exception, SystemExit)
    assert "the equations use pow, expected + - * /" in done.output
