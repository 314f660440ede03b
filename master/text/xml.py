"""XML of others as data: no entities, nothing fetched."""

from __future__ import annotations

from xml.etree import ElementTree as ET
from xml.parsers import expat


class _Reached(Exception):  # noqa: N818 - the first element, after which no declaration of a type follows
    pass


def parsed_xml(content: bytes) -> ET.Element:
    """
    Parse a document that declares no type of its own, and with it no entities.

    Raises:
        ValueError: If it does.
        ParseError: If it is not XML.
    """
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse
    parser.StartElementHandler = _stop
    try:
        parser.Parse(content, True)
    except _Reached:
        pass
    except expat.ExpatError:
        pass  # said better below
    return ET.fromstring(content)


def _refuse(*_: object) -> None:
    raise ValueError("a declaration of a document type, expected none")


def _stop(*_: object) -> None:
    raise _Reached
