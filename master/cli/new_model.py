"""`dockloop new-model`: a model of one's own to start from, with its test."""

from __future__ import annotations

import keyword
from pathlib import Path
from string import Template

import click

from master.errors import ConfigError, Problem
from master.recording.folder import reason

from .common import answers_errors, say

_MODEL = Template('''"""
$title: say in a line what it is.

    M q'' = f - F,   F = d q'  (slot `friction`)

Inputs   f [N]
Outputs  q [m], der_q [m/s] (states)   direct feedthrough: none
States   q, der_q                      start: 0
Slots    friction: d q', of q and der_q
Source   where the equation is from.
"""

from fmu_sources.framework.model import Model, Slot, no_effect
from fmu_sources.framework.variables import declare, input_, output, parameter, state


class $cls(Model):
    """See the module's text; it goes into the FMU."""

    name = "$name"
    description = "$title."
    # Every variable is declared here, once: name, (start value of a parameter,) unit, description.
    variables = declare(
        parameter("mass", 10.0, "kg", "Mass M", above=0.0),
        parameter("damping", 5.0, "N s/m", "Viscous friction d", minimum=0.0),
        input_("f", "N", "Driving force"),
        state("q", "m", "Position", output=True),
        state("der_q", "m/s", "Velocity", output=True),
        output("power", "W", "Power of the driving force"),
    )
    # A slot is a place where a diagnosis may add a law; its signals are named q and der_q for a position.
    slots = (Slot("friction", "N", "Friction", {"q": "m", "der_q": "m/s"}),)

    def derivatives(self, t, x, u, p, m, slot=no_effect):
        """Return the rate of every state. x: states, u: inputs, p: parameters, m: sqrt, sin, where, ..."""
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        return {"q": x.der_q, "der_q": (u.f - friction) / p.mass}

    def outputs(self, t, x, u, p, m, slot=no_effect):
        """Return every output that is no state."""
        return {"power": u.f * x.der_q}


MODEL = $cls()
''')
_TEST = Template('''"""Run it with pytest: the model against the exact solution of its equation."""

import math

import pytest
from $name import MODEL

from fmu_sources.framework.instance import Instance


def test_a_constant_force_leads_to_its_final_speed_exponentially():
    model = Instance(MODEL)
    model["f"] = 2.0
    model.initialise()
    for k in range(1000):
        model.step(k * 1e-3, 1e-3)

    assert model["der_q"] == pytest.approx(2.0 / 5.0 * (1.0 - math.exp(-5.0 / 10.0 * 1.0)), rel=1e-9)
    assert model["power"] == pytest.approx(2.0 * model["der_q"])
''')


@click.command("new-model")
@click.argument("name")
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path(),
    metavar="DIR",
    help="Folder for the two files; the present one by default.",
)
@answers_errors
def new_model(name: str, output: Path) -> None:
    """Write NAME.py, a commented model to change, and test_NAME.py, its test."""
    if not name.isidentifier() or keyword.iskeyword(name) or not name.isascii() or "__" in name:
        expected = "a name of letters, digits and single underscores, as in Python"
        raise ConfigError([Problem("NAME", got=repr(name), expected=expected)])
    words = name.strip("_").split("_")
    named = {
        "name": name,
        "cls": "".join(w.capitalize() for w in words),
        "title": " ".join(words).capitalize(),
    }
    texts = {
        output / f"{name}.py": _MODEL.substitute(named),
        output / f"test_{name}.py": _TEST.substitute(named),
    }
    there = [file for file in texts if file.exists()]
    if there:
        raise ConfigError([Problem("is there already", where=str(f), expected="another NAME") for f in there])
    for file, text in texts.items():
        try:
            output.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(file))]) from None
    model, test = texts
    say(f"{model}: a mass with friction; change it, then: pytest {test}; dockloop build {model}")
