"""
Templates of pages, in the folder `templates` of the package that writes the page, all values escaped.

Names and messages that come from an FMU or a recording are data: no page turns them into HTML.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from . import palette
from .encoding import page_data
from .picture import data_uri

_SCRIPT = "uPlot.iife.min.js"


@cache
def _environment(package: str) -> Environment:
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package), PackageLoader(__package__ or "")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"number": number, "sentence": sentence}
    environment.globals |= {
        "palette": palette,
        "page_data": page_data,
        "picture": data_uri,
        "plotting_library": plotting_library,
    }
    return environment


def render(package: str, template: str, **content: Any) -> str:
    """
    Fill in a template.

    Args:
        package: Name of the package whose folder `templates` holds it; it may extend `base.html.j2`.
        template: Name of its file.
        content: What its names mean.
    """
    return _environment(package).get_template(template).render(content)


def plotting_library() -> Markup:
    """Return the vendored script, as it is."""
    file = files(__package__ or "").joinpath("vendor", _SCRIPT)
    return Markup(file.read_text(encoding="utf-8"))


def number(value: float | str | None, digits: int = 4) -> str:
    """Format a number for people; a dash where there is none."""
    return "-" if value is None else f"{float(value):.{digits}g}"


def sentence(text: str) -> str:
    """Begin a sentence with a capital, unless its first word is a symbol, and end it with a full stop."""
    first = text.split(" ", 1)[0]
    return f"{text[:1].upper() if first.isalpha() else text[:1]}{text[1:]}."
