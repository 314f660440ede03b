"""C text from a CasADi function: one statement an operation, in the order of the trace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from .errors import NativeBuildError

_FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "floor", "fabs", "cosh", "sinh")
_CHOOSE = -1
_FORMATS: dict[int, str] = {
    _CHOOSE: "{0} ? {1} : {2}",
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}",
    ca.OP_EQ: "{0} == {1}",
    ca.OP_NE: "{0} != {1}",
    ca.OP_NOT: "!{0}",
    ca.OP_AND: "{0} && {1}",
    ca.OP_OR: "{0} || {1}",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0.0",
    ca.OP_SIGN: "({0} > 0.0) - ({0} < 0.0)",
    **{getattr(ca, f"OP_{name.upper()}"): name + "({0})" for name in _FUNCTIONS},
}


@dataclass(frozen=True)
class _Value:
    """An operand: its C text; its operation and operands if it is a statement."""

    text: str
    operation: int = ca.OP_PARAMETER
    operands: tuple[_Value, ...] = ()

    @property
    def right_side(self) -> str:
        if self.operation not in _FORMATS:
            names = {getattr(ca, n): n.removeprefix("OP_").lower() for n in dir(ca) if n.startswith("OP_")}
            raise NativeBuildError(
                f"the equations use {names.get(self.operation, self.operation)}, expected + - * / and the "
                "functions of m; a power is written as a product, a * a"
            )
        return _FORMATS[self.operation].format(*(v.text for v in self.operands))


def emit(function: Any, arguments: tuple[str, ...], result: str) -> list[str]:
    """Write the statements of a scalar function; arguments and result are names of C variables."""
    statements, results = _values(function, arguments)
    used = _used(results)
    lines = [f"const double {v.text} = {v.right_side};" for v in statements if v.text in used]
    return lines + [f"{result}[{i}] = {v.text};" for i, v in enumerate(results)]


def _values(function: Any, arguments: tuple[str, ...]) -> tuple[list[_Value], list[_Value]]:
    work: dict[int, _Value] = {}
    statements: list[_Value] = []
    results = [_Value("0.0")] * function.numel_out(0)
    for k in range(function.n_instructions()):
        operation, places = function.instruction_id(k), function.instruction_output(k)
        if operation == ca.OP_CONST:
            work[places[0]] = _Value(_literal(function.instruction_constant(k)))
        elif operation == ca.OP_INPUT:
            argument, i = function.instruction_input(k)
            name = arguments[argument]
            work[places[0]] = _Value(name if name == "t" else f"{name}[{i}]")
        elif operation == ca.OP_OUTPUT:
            results[places[1]] = work[function.instruction_input(k)[0]]
        else:
            operands = tuple(work[i] for i in function.instruction_input(k))
            statements.append(_statement(f"a{len(statements)}", operation, operands))
            work[places[0]] = statements[-1]
    return statements, results


def _statement(name: str, operation: int, operands: tuple[_Value, ...]) -> _Value:
    """Join `c ? a : 0` and `!c ? b : 0` to `c ? a : b`, which also keeps the sign of a zero."""
    if operation == ca.OP_ADD and all(v.operation == ca.OP_IF_ELSE_ZERO for v in operands):
        (condition, if_true), (opposite, if_false) = (v.operands for v in operands)
        if opposite.operation == ca.OP_NOT and opposite.operands[0].text == condition.text:
            return _Value(name, _CHOOSE, (condition, if_true, if_false))
    return _Value(name, operation, operands)


def _used(results: list[_Value]) -> set[str]:
    found: set[str] = set()
    waiting = list(results)
    while waiting:
        v = waiting.pop()
        if v.text not in found:
            found.add(v.text)
            waiting.extend(v.operands)
    return found


def _literal(value: float) -> str:
    assert float("-inf") < value < float("inf"), "a model has finite constants"
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text
