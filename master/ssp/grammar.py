"""
What of SSP is understood: every element with its attributes and children; the rest is refused by name.

Source  System Structure and Parameterization 1.0 and 2.0, Modelica Association (2019, 2024): the schemas.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from .markup import Rule, boolean, double, integer, words
from .names import PREFIXES, WHOLE_TYPES, ssb, ssc, ssd, ssm, ssv

Reader = Callable[[str], object]

_VERSION = re.compile(r"1\.[0-9]+(-.*)?|2\.0(-.*)?")
_META = ("author", "fileversion", "copyright", "license", "generationTool", "generationDateAndTime")
REAL_TYPES = ("Real", "Float64", "Float32")
_TYPES = (*REAL_TYPES, "Integer", *WHOLE_TYPES, "Boolean", "String", "Enumeration", "Binary", "Clock")
_TRANSFORMATIONS = {
    "LinearTransformation",
    "BooleanMappingTransformation",
    "IntegerMappingTransformation",
    "EnumerationMappingTransformation",
}
_KINDS = words(
    "input", "output", "parameter", "calculatedParameter", "inout", "structuralParameter", "constant", "local"
)


def everywhere(name: str) -> set[str]:
    """Give the names of an element that each schema declares for its own namespace."""
    return {f"{{{uri}}}{name}" for uri in PREFIXES.values()}


def _version(text: str) -> str:
    if _VERSION.fullmatch(text) is None:
        raise ValueError("expected 1.0 or 2.0")
    return text


def _name(text: str) -> str:
    if not text:
        raise ValueError("expected a name")
    return text


def _rule(
    children: Iterable[str] = (),
    many: Iterable[str] = (),
    required: Iterable[str] = (),
    **attributes: Reader,
) -> Rule:
    """Rule of an element that may be annotated, described and identified."""
    base: dict[str, Reader] = {"id": str, "description": str}
    needed = set(required)
    return Rule(
        attributes=base | attributes,
        required=frozenset(needed),
        children=frozenset({*children, *many, *everywhere("Annotations")}),
        many=frozenset(many),
    )


def _plain(required: Iterable[str] = (), **attributes: Reader) -> Rule:
    return Rule(attributes=attributes, required=frozenset(required))


def _holds(*children: str) -> Rule:
    return Rule(children=frozenset(children), many=frozenset(children))


_OPAQUE = Rule(opaque=True)


def _geometry(*attributes: str) -> Rule:
    return Rule(attributes=dict.fromkeys(attributes, str), opaque=True)


_meta = dict.fromkeys(_META, str)
_unit_exponents: dict[str, Reader] = dict.fromkeys(("kg", "m", "s", "A", "K", "mol", "cd", "rad"), integer)
_definitions = everywhere("Enumerations") | everywhere("Units")
_harmless = everywhere("MetaData") | everywhere("Signature")

_COMMON: dict[str, Rule] = {
    **dict.fromkeys(everywhere("Annotations"), _holds(ssc("Annotation"))),
    ssc("Annotation"): Rule(attributes={"type": str, "id": str, "description": str}, opaque=True),
    **dict.fromkeys(_harmless, _OPAQUE),
    **dict.fromkeys(everywhere("Enumerations"), _holds(ssc("Enumeration"))),
    **dict.fromkeys(everywhere("Units"), _holds(ssc("Unit"))),
    ssc("Item"): _plain(("name", "value"), name=_name, value=integer),
    ssc("Unit"): _rule({ssc("BaseUnit")}, {ssc("DisplayUnit")}, ("name",), name=_name),
    ssc("BaseUnit"): Rule(attributes=_unit_exponents | {"factor": double, "offset": double}),
    ssc("DisplayUnit"): Rule(attributes=dict.fromkeys(("name", "factor", "offset", "inverse"), str)),
    # a definition with items, and the type of a connector
    ssc("Enumeration"): _rule(many={ssc("Item")}, required=("name",), name=_name),
    **{ssc(name): _plain(unit=_name) for name in REAL_TYPES},
    **{ssc(name): _plain() for name in ("Integer", *WHOLE_TYPES, "Boolean", "String")},
    ssc("Binary"): Rule(attributes={"mime-type": str}),
    ssc("Clock"): _plain(name=str, intervalVariability=str),
    ssc("Dimension"): _plain(size=integer, sizeConnector=str),
    ssc("LinearTransformation"): _plain(factor=double, offset=double),
    **{ssc(name): _holds(ssc("MapEntry")) for name in _TRANSFORMATIONS - {"LinearTransformation"}},
    ssc("MapEntry"): _plain(("source", "target"), source=str, target=str),
}
_types = {ssc(name) for name in _TYPES}
_transformations = {ssc(name) for name in _TRANSFORMATIONS}

MAPPING: dict[str, Rule] = {
    **_COMMON,
    ssm("ParameterMapping"): _rule(_harmless, {ssm("MappingEntry")}, ("version",), version=_version, **_meta),
    ssm("MappingEntry"): _rule(
        _transformations, (), ("source", "target"), source=str, target=str, suppressUnitConversion=boolean
    ),
}

VALUES: dict[str, Rule] = {
    **_COMMON,
    ssv("ParameterSet"): _rule(
        {ssv("Parameters"), *_definitions, *_harmless}, (), ("version",), version=_version, name=str, **_meta
    ),
    ssv("Parameters"): _holds(ssv("Parameter")),
    ssv("Parameter"): _rule(
        {*(ssv(name) for name in _TYPES), ssc("Dimension")}, {ssc("Dimension")}, ("name",), name=str
    ),
    **{ssv(name): _plain(("value",), value=str, unit=_name) for name in REAL_TYPES},
    **{ssv(name): _plain(("value",), value=str) for name in ("Integer", *WHOLE_TYPES, "Boolean")},
    ssv("String"): Rule(
        attributes={"value": str}, children=frozenset({ssv("Value")}), many=frozenset({ssv("Value")})
    ),
    ssv("Enumeration"): Rule(
        attributes={"value": str, "name": str},
        children=frozenset({ssv("Value")}),
        many=frozenset({ssv("Value")}),
    ),
    ssv("Value"): _plain(("value",), value=str),
    ssv("Binary"): Rule(attributes={"value": str, "mime-type": str}, opaque=True),
    ssv("Clock"): _OPAQUE,
}

DICTIONARY: dict[str, Rule] = {
    **_COMMON,
    ssb("SignalDictionary"): _rule(
        {*_definitions, *_harmless}, {ssb("DictionaryEntry")}, ("version",), version=_version, **_meta
    ),
    ssb("DictionaryEntry"): _rule({*_types, ssc("Dimension")}, {ssc("Dimension")}, ("name",), name=_name),
}

_element = {ssd("Connectors"), ssd("ElementGeometry"), ssd("ParameterBindings")}

STRUCTURE: dict[str, Rule] = {
    **MAPPING,
    **VALUES,
    **DICTIONARY,
    ssd("SystemStructureDescription"): _rule(
        {
            ssd("System"),
            ssd("DefaultExperiment"),
            *_definitions,
            *_harmless,
        },
        (),
        ("version",),
        version=_version,
        name=str,
        **_meta,
    ),
    ssd("DefaultExperiment"): _rule(startTime=double, stopTime=double),
    ssd("System"): _rule(
        {
            *_element,
            ssd("Elements"),
            ssd("Connections"),
            ssd("SignalDictionaries"),
            ssd("SystemGeometry"),
            ssd("GraphicalElements"),
        },
        required=("name",),
        name=_name,
    ),
    ssd("Elements"): _holds(ssd("Component"), ssd("System"), ssd("SignalDictionaryReference")),
    ssd("Component"): _rule(
        _element,
        required=("name", "source"),
        name=_name,
        source=str,
        type=str,
        implementation=words("any", "CoSimulation", "ModelExchange", "ScheduledExecution"),
    ),
    ssd("SignalDictionaryReference"): _rule(
        _element, required=("name", "dictionary"), name=_name, dictionary=str
    ),
    ssd("SignalDictionaries"): _holds(ssd("SignalDictionary")),
    ssd("SignalDictionary"): _rule(
        {ssb("SignalDictionary")}, required=("name",), name=_name, type=str, source=str
    ),
    ssd("Connectors"): _holds(ssd("Connector")),
    ssd("Connector"): _rule(
        {*_types, ssd("ConnectorGeometry"), ssc("Dimension")},
        {ssc("Dimension"), ssc("Clock")},
        ("name", "kind"),
        name=_name,
        kind=_KINDS,
    ),
    ssd("Connections"): _holds(ssd("Connection")),
    ssd("Connection"): _rule(
        {*_transformations, ssd("ConnectionGeometry")},
        required=("startConnector", "endConnector"),
        startElement=str,
        startConnector=str,
        endElement=str,
        endConnector=str,
        suppressUnitConversion=boolean,
    ),
    ssd("ParameterBindings"): _holds(ssd("ParameterBinding")),
    ssd("ParameterBinding"): _rule(
        {ssd("ParameterValues"), ssd("ParameterMapping")},
        type=str,
        source=str,
        sourceBase=words("SSD", "component"),
        prefix=str,
    ),
    ssd("ParameterValues"): Rule(children=frozenset({ssv("ParameterSet")})),
    ssd("ParameterMapping"): _rule(
        {ssm("ParameterMapping")}, type=str, source=str, sourceBase=words("SSD", "component")
    ),
    ssd("ConnectorGeometry"): _geometry("x", "y", "systemInnerX", "systemInnerY"),
    ssd("ConnectionGeometry"): _geometry("pointsX", "pointsY"),
    ssd("ElementGeometry"): _geometry(
        *("x1", "y1", "x2", "y2", "rotation"),
        *("iconSource", "iconRotation", "iconFlip", "iconFixedAspectRatio"),
    ),
    ssd("SystemGeometry"): _geometry("x1", "y1", "x2", "y2"),
    ssd("GraphicalElements"): _OPAQUE,
}
