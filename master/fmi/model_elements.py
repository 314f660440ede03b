"""Parts of a model description: attributes that are checked as they are read, units, declared types."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from master.errors import ConfigError

from .units import Unit

_INTEGER = re.compile(r"[+-]?\d{1,30}")
_NUMBER = re.compile(r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf|infinity)|nan", re.IGNORECASE)
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}
_NO_ITEMS: Mapping[str, int] = {}
_EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


class Faults:
    """Collects what is wrong in one model description, each with the element where it is."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._found: dict[str, None] = {}

    def add(self, where: str, what: str) -> None:
        """Note a fault."""
        self._found[f"{self._path}: modelDescription.xml: {where}: {what}"] = None

    def raise_if_any(self, most: int) -> None:
        """Raise ConfigError with at most so many of the faults, and the number of the others."""
        found = list(self._found)
        if len(found) > most:
            found = [*found[:most], f"{self._path}: modelDescription.xml: {len(found) - most} more faults"]
        if found:
            raise ConfigError(found)

    @staticmethod
    def is_integer(text: str) -> bool:
        """Whether a text is an integer as XML writes it."""
        return _INTEGER.fullmatch(text) is not None

    @staticmethod
    def is_number(text: str) -> bool:
        """Whether a text is a number as XML writes it, infinite or none included."""
        return _NUMBER.fullmatch(text) is not None

    def integer(
        self, e: ET.Element, key: str, where: str, least: int, largest: int, *, required: bool = False
    ) -> int | None:
        """Read an integer within bounds; None if it is missing or, which is noted, is not one."""
        text = e.get(key)
        if text is None and not required:
            return None
        if text is None or not self.is_integer(text.strip()) or not least <= int(text) <= largest:
            got = "missing" if text is None else f"got {text!r}"
            self.add(where, f"{key}: {got}, expected an integer from {least} to {largest}")
            return None
        return int(text)

    def number(
        self, attributes: Mapping[str, str], key: str, where: str, *, of_integers: bool = False
    ) -> float | None:
        """Read a number, of integers exactly; None if it is missing or, which is noted, is none."""
        text = attributes.get(key)
        if text is None:
            return None
        stripped = text.strip()
        if of_integers and self.is_integer(stripped):
            return int(stripped)
        if of_integers or not self.is_number(stripped):
            self.add(where, f"{key}: got {text!r}, expected {'an integer' if of_integers else 'a number'}")
            return None
        return float(stripped)

    def truth(self, e: ET.Element, key: str, where: str) -> bool | None:
        """Read a Boolean; None if it is missing or, which is noted, is not one."""
        text = e.get(key)
        if text is not None and text.strip() not in _TRUTHS:
            self.add(where, f"{key}: got {text!r}, expected true or false")
        return None if text is None else _TRUTHS.get(text.strip())

    def choice(self, e: ET.Element, key: str, where: str, allowed: Collection[str]) -> str | None:
        """Read one of some words; None if it is missing or, which is noted, is none of them."""
        text = e.get(key)
        if text is not None and text not in allowed:
            self.add(where, f"{key}: got {text!r}, expected one of {', '.join(allowed)}")
            return None
        return text


class ModelTypes:
    """Units and declared types of a description; a variable has what its type has and itself does not."""

    def __init__(self, root: ET.Element, is_2: bool, faults: Faults) -> None:
        self._faults = faults
        self._units = {e.get("name", ""): self._unit(e) for e in root.iterfind("UnitDefinitions/Unit")}
        self._relative: dict[str, Unit] = {}
        self._types: dict[str, ET.Element] = {}
        self._items: dict[str, dict[str, int]] = {}
        for e in root.iterfind("TypeDefinitions/*"):
            typed = next(iter(e), None) if is_2 else e
            if typed is not None:
                self._types[e.get("name", "")] = typed
                self._items[e.get("name", "")] = self._read_items(typed, e.get("name", ""))

    def attributes(self, typed: ET.Element, where: str) -> Mapping[str, str]:
        """Attributes of a variable, those of its declared type where it has none of its own."""
        name = typed.get("declaredType")
        if name is None:
            return typed.attrib
        declared = self._types.get(name)
        if declared is None or declared.tag not in (typed.tag, f"{typed.tag}Type"):
            got = "which is not defined" if declared is None else f"which is a {declared.tag}"
            self._faults.add(where, f"declaredType: got {name!r}, {got}, expected a type of {typed.tag}")
            return typed.attrib
        return {**declared.attrib, **typed.attrib}

    def items(self, typed: ET.Element) -> Mapping[str, int]:
        """Items of an enumeration by name."""
        return (
            self._items.get(typed.get("declaredType", ""), _NO_ITEMS)
            if typed.tag == "Enumeration"
            else _NO_ITEMS
        )

    def unit(self, attributes: Mapping[str, str]) -> Unit | None:
        """Unit of a variable; a difference, of temperatures for example, has none of the unit's offset."""
        name = attributes.get("unit")
        if not name:
            return None
        unit = self._units.get(name) or Unit(name, defined=False)
        if not _TRUTHS.get(attributes.get("relativeQuantity", "false"), False) or not unit.offset:
            return unit
        if name not in self._relative:
            self._relative[name] = replace(unit, offset=0.0)
        return self._relative[name]

    def _read_items(self, typed: ET.Element, name: str) -> dict[str, int]:
        found: dict[str, int] = {}
        for item in typed.iterfind("Item"):
            where = f"TypeDefinitions {name!r}: Item {item.get('name')!r}"
            value = self._faults.integer(item, "value", where, -(2**63), 2**63 - 1, required=True)
            if value is not None:
                found[item.get("name", "")] = value
        return found

    def _unit(self, e: ET.Element) -> Unit:
        name, base = e.get("name", ""), e.find("BaseUnit")
        if base is None:
            return Unit(name, defined=False)
        where = f"UnitDefinitions/Unit {name!r}"
        exponents = {key: self._faults.integer(base, key, where, -1000, 1000) or 0 for key in _EXPONENTS}
        factor = self._faults.number(base.attrib, "factor", where)
        offset = self._faults.number(base.attrib, "offset", where) or 0.0
        factor = 1.0 if factor is None else factor
        if not (math.isfinite(factor) and factor and math.isfinite(offset)):
            self._faults.add(
                where,
                f"cannot be converted, got factor {factor:g} and offset {offset:g}, expected finite numbers "
                "and a factor that is not zero",
            )
            return Unit(name, defined=False)
        return Unit(name, {key: n for key, n in exponents.items() if n}, factor, offset)
