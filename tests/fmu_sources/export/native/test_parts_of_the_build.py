"""The small parts of a native build: statements, tables, libraries without a time."""

from __future__ import annotations

import struct

import casadi
import pytest

from fmu_sources.composed import registry
from fmu_sources.export.native.casadi_arithmetic import CASADI, as_written
from fmu_sources.export.native.emit import emit
from fmu_sources.export.native.errors import MissingToolError
from fmu_sources.export.native.normalise import normalise
from fmu_sources.export.native.tables import header, quoted, tables
from fmu_sources.framework.integrate import MOST_SAMPLES, MOST_SUBSTEPS
from fmu_sources.framework.variables import Role


def emitted(expression):
    with as_written():
        x = casadi.SX.sym("x", 2)
        return emit(casadi.Function("f", [x], [expression(x[0], x[1])]), ("x",), "y")


def test_one_statement_an_operation_as_it_is_written():
    assert emitted(lambda a, b: (a + b) * 0.1) == [
        "const double a0 = x[0] + x[1];",
        "const double a1 = a0 * 0.1;",
        "y[0] = a1;",
    ]


def test_a_choice_is_one_conditional_and_keeps_its_sides():
    *_, choice, result = emitted(lambda a, b: CASADI.where(a < b, -a, b))

    assert "?" in choice
    assert choice.count(":") == 1
    assert "0.0" not in choice
    assert result.startswith("y[0] = ")


def test_what_no_result_uses_is_not_written():
    assert emitted(lambda a, b: casadi.vertcat(a, 2.5)) == ["y[0] = x[0];", "y[1] = 2.5;"]


@pytest.mark.parametrize(("text", "written"), [("a", '"a"'), ('a "b"', '"a \\"b\\""'), ("a\\b", '"a\\\\b"')])
def test_a_text_becomes_a_c_string(text, written):
    assert quoted(text) == written


@pytest.mark.parametrize("name", registry.model_files())
def test_the_rules_in_c_are_worded_as_those_in_python(name):
    model = registry.load(name)
    written = tables(model)
    for v in [*model.group(Role.PARAMETER), *model.group(Role.INPUT)]:
        bounds = (("above", v.above), ("at least", v.minimum), ("at most", v.maximum))
        for words, bound in bounds:
            if bound is not None:
                beyond = bound - 1.0 if words != "at most" else bound + 1.0
                rule = v.broken_rule(beyond)
                assert rule is not None
                assert v.items or quoted(f"{words} {bound!r}") in written


def test_the_header_counts_and_has_the_limits_of_a_step():
    model = registry.load("spacecraft")
    text = header(model, "{g}")

    for line in (
        "N_PARAMETERS = 3",
        "N_INPUTS = 1",
        "N_STATES = 3",
        "N_CONTINUOUS = 0",
        "SAMPLE_TIME = 1",
        "INPUT_HOLD = -1",
        f"MOST_SAMPLES = {MOST_SAMPLES}",
        f"MOST_SUBSTEPS = {MOST_SUBSTEPS}",
        '#define MODEL_GUID "{g}"',
    ):
        assert line in text


def windows_library(stamp, checksum):
    content = bytearray(256)
    content[:2] = b"MZ"
    struct.pack_into("<I", content, 0x3C, 64)
    content[64:68] = b"PE\0\0"
    struct.pack_into("<I", content, 64 + 8, stamp)
    struct.pack_into("<I", content, 64 + 24 + 64, checksum)
    return bytes(content)


def test_windows_libraries_of_two_days_are_the_same():
    assert normalise(windows_library(1, 2)) == normalise(windows_library(3, 4)) == windows_library(0, 0)


def test_other_libraries_stay_as_they_are():
    assert normalise(b"\x7fELF" + b"\x01" * 100) == b"\x7fELF" + b"\x01" * 100


def test_a_missing_tool_says_how_to_get_it():
    assert "casadi is not installed, expected: pip install" in str(MissingToolError("casadi"))
