"""
The generated equations of a model with all that parameters decide computed once, when parameters are checked.

Each rule gives the same bits as the equations as they are written:

* an operation on parameters alone is computed once, and its result kept;
* a chain of choices between states by conditions on parameters, as a delay line has, becomes an index;
* a row of states of which each takes the value of its neighbour, as in a delay line, is moved at once;
* in `c + f * sin(a)`, with c and f of parameters alone, the sine is not computed where f is zero and a is
  finite: whatever it is, the product is a zero, which changes no c but a negative zero.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

STEPPED = ("model_update", "model_derivatives", "model_outputs", "model_faults")
SHORTEST_CHAIN = 4
SHORTEST_ROW = 16

_FUNCTION = re.compile(r"^void (?P<name>model_\w+)\(.*?\) \{\n(?P<body>.*?)^\}\n", re.MULTILINE | re.DOTALL)
_STATEMENT = re.compile(r"^    const double (a\d+) = (.*);$")
_OPERAND = re.compile(r"(?<!\w)(?:a\d+|[xutp]|seed)(?!\w)")
_RESULT = re.compile(r"(?<!\w)a\d+(?!\w)")
_CHOICE = re.compile(r"(a\d+) \? x\[(\d+)\] : (a\d+|[xu]\[\d+\])$")
_WAVE = re.compile(r"(sin|cos)\((a\d+)\)$")
_TAKEN = re.compile(r"^    new_x\[(\d+)\] = x\[(\d+)\];$")
_PRODUCT = re.compile(r"(\S+) \* (\S+)$")
_SUM = re.compile(r"(\S+) \+ (\S+)$")
_OF_DATA = "    const double *prepared = ((const Data *)p)->prepared; /* p is the first member of the data */"


@dataclass(frozen=True)
class Row:
    """`n` states from `first` on, each of which takes the value of the state `shift` places further."""

    first: int
    n: int
    shift: int


@dataclass(frozen=True)
class Equations:
    """
    A C file of equations with `model_prepare` at its end.

    `n_prepared` is how many numbers that keeps, `moved` a row of states that `model_update` leaves alone.
    """

    text: str
    n_prepared: int
    moved: Row | None


def with_prepared(equations: str) -> Equations:
    """
    Move what parameters decide to `model_prepare`, and leave out the directional derivative.

    Raises:
        ValueError: If the file is not as the generator writes it.
    """
    top = equations[: equations.index("void model_")]
    functions: list[str] = []
    n_prepared = 0
    moved = None
    blocks: list[str] = []
    for found in _FUNCTION.finditer(equations):
        if found["name"] == "model_outputs_along":
            continue
        if found["name"] not in STEPPED:
            functions.append(found[0])
            continue
        lines = found["body"].splitlines()
        if found["name"] == "model_update":
            moved = _longest_row(lines)
            lines = [line for line in lines if moved is None or not _is_moved(line, moved)]
        split = _Split(lines, n_prepared)
        blocks += split.preparation()
        n_prepared = split.n_prepared
        functions.append(
            "\n".join([*split.tables, found[0].replace(found["body"], split.body())]).lstrip("\n")
        )
    head = ["void model_prepare(const double *p, double *prepared) {", "    (void)p, (void)prepared;"]
    prepare = "\n".join([*head, *blocks, "}", ""])
    return Equations(top + '#include "instance.h"\n\n' + "\n".join([*functions, prepare]), n_prepared, moved)


def _longest_row(lines: Sequence[str]) -> Row | None:
    """Find the longest row of states that take their neighbours' values; None if there is no long one."""
    best: Row | None = None
    row: Row | None = None
    for line in lines:
        taken = _TAKEN.match(line)
        if taken is None or taken[1] == taken[2]:
            row = None
            continue
        state, shift = int(taken[1]), int(taken[2]) - int(taken[1])
        goes_on = row is not None and shift == row.shift and state == row.first + row.n
        row = Row(row.first, row.n + 1, shift) if row is not None and goes_on else Row(state, 1, shift)
        if row.n >= SHORTEST_ROW and (best is None or row.n > best.n):
            best = row
    return best


def _is_moved(line: str, row: Row) -> bool:
    taken = _TAKEN.match(line)
    return taken is not None and row.first <= int(taken[1]) < row.first + row.n


@dataclass
class _Split:
    """One function: what is prepared, from a cell on, and what is computed each time."""

    lines: Sequence[str]
    first: int
    tables: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.constant: dict[str, str] = {}
        self.kept: dict[str, str] = {}
        self.results: list[str] = []
        for line in self.lines[1:]:
            statement = _STATEMENT.match(line)
            if statement is None:
                self.results.append(line)
                continue
            name, text = statement[1], statement[2]
            group = self.constant if self._is_constant(text) else self.kept
            group[name] = text
        self.stored: dict[str, str] = {}
        self._index_choices()
        self._skip_waves()
        left = "\n".join([*self.kept.values(), *self.results])
        used = set(_RESULT.findall(left))
        self.stored |= {name: name for name in self.constant if name in used}
        self.cells = {name: self.first + i for i, name in enumerate(self.stored)}

    @property
    def n_prepared(self) -> int:
        """Number of cells up to the end of those of this function."""
        return self.first + len(self.stored)

    def preparation(self) -> Iterator[str]:
        """Lines that compute what is prepared, in a block of their own."""
        if self.stored:
            yield "    {"
            yield from (f"        const double {name} = {text};" for name, text in self.constant.items())
            yield from (
                f"        prepared[{self.cells[name]}] = {text};" for name, text in self.stored.items()
            )
            yield "    }"

    def body(self) -> str:
        """The function without what is prepared."""
        lines = [self.lines[0]]
        if self.stored:
            lines.append(_OF_DATA)
        lines += [f"    const double {name} = prepared[{cell}];" for name, cell in self.cells.items()]
        lines += [f"    const double {name} = {text};" for name, text in self.kept.items()]
        return "".join(f"{line}\n" for line in [*lines, *self.results])

    def _is_constant(self, text: str) -> bool:
        return set(_OPERAND.findall(text)) <= {"p", *self.constant}

    def _uses(self) -> Counter[str]:
        return Counter(_RESULT.findall("\n".join([*self.kept.values(), *self.results])))

    def _index_choices(self) -> None:
        """Turn chains of choices between states into one look-up by a prepared index."""
        uses = self._uses()
        chains: dict[str, list[str]] = {}
        for name, text in self.kept.items():
            choice = _CHOICE.match(text)
            if choice is None or choice[1] not in self.constant:
                continue
            before = chains.pop(choice[3], []) if uses[choice[3]] == 1 else []
            chains[name] = [*before, name]
        for last, chain in chains.items():
            if len(chain) >= SHORTEST_CHAIN:
                self._index(last, chain)

    def _index(self, last: str, chain: Sequence[str]) -> None:
        choices = [_CHOICE.match(self.kept[name]) for name in chain]
        found = [choice for choice in choices if choice is not None]
        index, table = f"index_{last}", f"states_{last}_{self.first}"
        numbers = [f"{found[i][1]} ? {i + 1}.0 : " for i in reversed(range(len(found)))]
        self.stored[index] = "".join(numbers) + "0.0"
        states = ", ".join(choice[2] for choice in found)
        self.tables.append(f"static const short {table}[] = {{0, {states}}};\n")
        for name in chain[:-1]:
            del self.kept[name]
        self.kept[last] = f"{index} == 0.0 ? {found[0][3]} : x[{table}[(int){index}]]"

    def _skip_waves(self) -> None:
        """Leave out sines and cosines whose factor is zero."""
        uses = self._uses()
        for name, text in list(self.kept.items()):
            wave = _WAVE.match(text)
            product = self._only_user(name, _PRODUCT, uses) if wave else None
            total = self._only_user(product.name, _SUM, uses) if product else None
            if wave is None or product is None or total is None:
                continue
            if not (self._is_constant(product.other) and self._is_constant(total.other)):
                continue
            skip = f"skip_{name}"
            factor, term = product.other, total.other
            self.stored[skip] = f"{factor} == 0.0 && !({term} == 0.0 && signbit({term}))"
            self.kept[name] = f"{skip} != 0.0 && isfinite({wave[2]}) ? 0.0 : {text}"

    def _only_user(self, name: str, form: re.Pattern[str], uses: Counter[str]) -> _User | None:
        """The one statement that takes a result, if it has a form of two operands."""
        if uses[name] != 1:
            return None
        for user, text in self.kept.items():
            found = form.match(text)
            if found is not None and name in found.groups():
                return _User(user, found[2] if found[1] == name else found[1])
        return None


@dataclass(frozen=True)
class _User:
    """A statement, and the operand that it takes next to the one in question."""

    name: str
    other: str
