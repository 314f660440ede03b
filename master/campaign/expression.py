"""Arithmetic with names of signals as people write it: `3.96 * contact.k_p + sqrt(contact.c_p)`."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_UNARY: dict[type[ast.unaryop], Callable[[float], float]] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS: dict[str, Callable[..., float]] = {
    **{
        name: getattr(math, name)
        for name in ("sqrt", "exp", "log", "log10", "sin", "cos", "tan", "atan", "atan2")
    },
    "abs": abs,
    "min": min,
    "max": max,
}
_CONSTANTS = {"pi": math.pi}


@dataclass(frozen=True)
class Expression:
    """Checked arithmetic; `names` are the signals in it, in order."""

    text: str
    tree: ast.expr
    names: tuple[str, ...]

    def value(self, values: Mapping[str, float]) -> float:
        """
        Compute it from the values of its names.

        Raises:
            ValueError: If it has no finite value there.
        """
        try:
            found = float(_value(self.tree, values))
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ValueError(f"{self.text!r} has no value: {error}") from None
        if not math.isfinite(found):
            raise ValueError(f"{self.text!r} is {found}")
        return found


def expression(text: str) -> Expression:
    """
    Read arithmetic: numbers, signals, + - * / **, brackets, and functions such as sqrt, exp, min.

    Raises:
        ValueError: If there is anything else in it.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError):
        raise ValueError("not arithmetic, expected numbers, signals, + - * / ** and brackets") from None
    names: dict[str, None] = {}
    _check(tree, names)
    return Expression(text.strip(), tree, tuple(names))


def _check(node: ast.expr, names: dict[str, None]) -> None:
    """Refuse what is no arithmetic; collect the names of signals."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            _check(left, names)
            _check(right, names)
        case ast.UnaryOp(op=sign, operand=operand) if type(sign) in _UNARY:
            _check(operand, names)
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if (
            name in _FUNCTIONS and arguments
        ):
            for argument in arguments:
                _check(argument, names)
        case ast.Name(id=name) if name in _CONSTANTS:
            return
        case ast.Attribute():
            names[_signal(node)] = None
        case _:
            functions = ", ".join(_FUNCTIONS)
            raise ValueError(
                f"not arithmetic: {ast.unparse(node)}, expected numbers, signals, + - * / ** and {functions}"
            )


def _signal(node: ast.expr) -> str:
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=inner, attr=name):
            return f"{_signal(inner)}.{name}"
    raise ValueError(f"not a signal: {ast.unparse(node)}, expected instance.variable")


def _value(node: Any, values: Mapping[str, float]) -> Any:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.BinOp(left=left, op=op, right=right):
            return _BINARY[type(op)](_value(left, values), _value(right, values))
        case ast.UnaryOp(op=sign, operand=operand):
            return _UNARY[type(sign)](_value(operand, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _FUNCTIONS[name](*(_value(argument, values) for argument in arguments))
        case ast.Name(id=name):
            return _CONSTANTS[name]
    return values[_signal(node)]
