"""Templates escape every value; the plotting library is the file of its release."""

from __future__ import annotations

import hashlib
import re
from importlib.resources import files
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder
from jinja2 import UndefinedError

from master.pages.render import _environment, number, plotting_library, sentence

VENDOR = files("master.pages").joinpath("vendor")
NASTY = "<script>alert(1)</script>"


def test_the_plotting_library_is_unmodified_small_and_has_its_licence():
    script = VENDOR.joinpath("uPlot.iife.min.js").read_bytes()
    [promised] = re.findall(r"`([0-9a-f]{64})`", VENDOR.joinpath("README.md").read_text())

    assert hashlib.sha256(script).hexdigest() == promised
    assert len(script) <= 300_000
    assert b"v1.6.32" in script[:100]
    assert "MIT License" in VENDOR.joinpath("uPlot.LICENSE").read_text()
    assert plotting_library().encode() == script


def test_nothing_that_a_table_shows_becomes_html():
    template = _environment("master.pages").from_string(
        '{% from "parts.html.j2" import table %}{{ table((head,), ((cell,),)) }}'
    )
    text = template.render(head=NASTY, cell=NASTY)

    assert "<script" not in text
    assert text.count("&lt;script&gt;alert(1)") == 3  # heading, cell, label for readers of the screen


def test_a_name_that_a_template_is_not_given_is_an_error():
    with pytest.raises(UndefinedError):
        _environment("master.pages").from_string("{{ missing }}").render()


def test_numbers_and_sentences_are_for_people():
    assert (number(None), number(0.000123456), number(12.0)) == ("-", "0.0001235", "12")
    assert sentence("the loop diverges") == "The loop diverges."
    assert sentence("f_des = 0") == "f_des = 0."


def test_the_wheel_takes_every_template_and_the_plotting_library_along():
    project = Path(__file__).parents[3]
    shipped = {Path(f.path) for f in WheelBuilder(str(project)).recurse_included_files()}
    folders = [f for name in ("templates", "vendor") for f in (project / "master").rglob(name)]

    assert len(folders) >= 4
    assert {f for folder in folders for f in folder.iterdir()} <= shipped
