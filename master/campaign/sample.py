"""The table of all runs: one column a varied value, one row a run, made before the first run."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from master.errors import ConfigError, Problem, nearest
from master.fmi.unit_names import unit as unit_of_name
from master.fmi.units import Conversion, Unit, conversion
from master.text.scalar import Plain, boolean_of, number_of

from .campaign import Campaign, Vary
from .design import correlated, grid_places, unit_points
from .distributions import drawn, has_room, places, points
from .expression import Expression, expression
from .target import Target

Array = NDArray[Any]
Where = Callable[..., str]
MOST_RUNS = 10**8


class BaseValues(Protocol):
    """The values of a system in which nothing varies."""

    def value(self, signal: str) -> Any:
        """Value of a signal; ValueError with a Problem if there is none."""
        ...

    def unit(self, signal: str) -> Unit | None:
        """Unit of a signal, None if it has none."""
        ...


@dataclass(frozen=True)
class Column:
    """Values of one key in all runs, shape (runs,), in the unit; `is_free`: it follows from no other."""

    target: Target
    values: Array
    is_free: bool

    @property
    def key(self) -> str:
        """Key in `vary`."""
        return self.target.key

    @property
    def unit(self) -> str:
        """Name of the unit, `1` if it has none."""
        return "1" if self.target.unit is None else self.target.unit.name

    @property
    def is_number(self) -> bool:
        """Whether all values are numbers."""
        return self.values.dtype.kind in "fi"

    def value(self, run: int) -> Any:
        """Value in one run: bool, int, float, text, or a list."""
        found = self.values[run]
        return found.item() if isinstance(found, np.generic) else found

    def part(self, runs: NDArray[np.int64]) -> Array:
        """Values in some runs as a column of a table: what is no number, truth or text as JSON."""
        chosen = self.values[runs]
        if chosen.dtype.kind != "O":
            return chosen
        return np.array([v if isinstance(v, str) else json.dumps(v) for v in chosen], dtype=object)


@dataclass(frozen=True)
class Sample:
    """All runs of a campaign; `free` counts the columns that a design of sensitivity varies."""

    columns: tuple[Column, ...]
    n_runs: int

    def values(self, run: int) -> dict[str, Any]:
        """Values of a run by key."""
        return {column.key: column.value(run) for column in self.columns}

    @property
    def free(self) -> tuple[Column, ...]:
        """Columns that follow from no other, in the order of the design."""
        return tuple(column for column in self.columns if column.is_free)


def make_sample(campaign: Campaign, targets: Mapping[str, Target], where: Where, base: BaseValues) -> Sample:
    """
    Make the table of a campaign.

    Args:
        campaign: What varies.
        targets: By key.
        where: Names a place of the campaign's file.
        base: Values that do not vary.

    Raises:
        ConfigError: With every fault: units, links that lead nowhere or in a circle, a grid of distributions.
    """
    return _Sampler(campaign, targets, where, base).sample()


class _Sampler:
    def __init__(
        self, campaign: Campaign, targets: Mapping[str, Target], where: Where, base: BaseValues
    ) -> None:
        self.campaign = campaign
        self.targets = targets
        self.where = where
        self.base = base
        self.problems: list[Problem] = []
        self.found: dict[str, Array] = {}
        self.n_runs = 1

    def sample(self) -> Sample:
        vary = self.campaign.vary
        free = {key: v for key, v in vary.items() if v.same_as is None and v.expression is None}
        linked = {key: v for key, v in vary.items() if key not in free}
        conversions = {key: self._conversion(key, v) for key, v in free.items()}
        for key, v in free.items():
            if not has_room(v):
                got = f"{v.kind} {list(getattr(v, v.kind))} within {list(v.bounds or ())}"
                self._add("bounds leave nothing", key, "bounds", got=got, expected="bounds around its values")
        if not self.problems:
            self._draw(free, conversions)
        if not self.problems:
            self._link(linked)
        if self.problems:
            raise ConfigError(self.problems)
        columns = tuple(Column(self.targets[key], self.found[key], key in free) for key in vary)
        return Sample(columns, self.n_runs)

    def _add(self, what: str, key: str, *place: str, got: str = "", expected: str = "") -> None:
        self.problems.append(Problem(what, where=self.where("vary", key, *place), got=got, expected=expected))

    def _conversion(self, key: str, v: Vary) -> Conversion:
        """From the unit of the file to that of the target."""
        if v.unit is None:
            return Conversion()
        own: Unit | None = self.targets[key].unit
        try:
            change = conversion(unit_of_name(v.unit), own)
        except ValueError as error:
            self._add(f"not a unit: {error}", key, "unit", got=repr(v.unit))
            return Conversion()
        if change is None or own is None:
            expected = "no unit" if own is None else f"one as {own.name}"
            self._add("another quantity", key, "unit", got=v.unit, expected=expected)
            return Conversion()
        return change

    def _draw(self, free: Mapping[str, Vary], conversions: Mapping[str, Conversion]) -> None:
        listed = {key: self._listed(key, v, conversions[key]) for key, v in free.items()}
        if self.problems:
            return
        if self.campaign.design.method == "grid":
            self._draw_grid(free, listed)
            return
        if not free:
            where = self.where("design")
            self.problems.append(
                Problem("nothing to draw", where=where, expected="a value that varies freely")
            )
            return
        shares = self._shares(list(free))
        if self.problems:
            return
        self.n_runs = len(shares)
        for i, (key, v) in enumerate(free.items()):
            values = listed[key]
            if values is not None:
                self.found[key] = values[places(v, len(values), shares[:, i])]
            else:
                self.found[key] = self._converted(v, drawn(v, shares[:, i]), conversions[key])

    def _draw_grid(self, free: Mapping[str, Vary], listed: Mapping[str, Array | None]) -> None:
        for key, v in free.items():
            if listed[key] is None:
                what = "a grid cannot have a distribution"
                expected = "values, linspace, logspace or choice, or another design with a size"
                self._add(what, key, v.kind, expected=expected)
        if self.campaign.correlations:
            where = self.where("correlations")
            self.problems.append(
                Problem("a grid has no correlations", where=where, expected="another design")
            )
        counts = [len(values) for values in listed.values() if values is not None]
        if math.prod(counts) > MOST_RUNS:
            self.problems.append(
                Problem(
                    "too many runs",
                    where=self.where("vary"),
                    got=str(math.prod(counts)),
                    expected=f"at most {MOST_RUNS}",
                )
            )
        if self.problems:
            return
        chosen = grid_places(counts)
        self.n_runs = len(chosen)
        for i, (key, values) in enumerate(listed.items()):
            assert values is not None
            self.found[key] = values[chosen[:, i]]

    def _shares(self, keys: Sequence[str]) -> NDArray[np.float64]:
        shares = unit_points(self.campaign.design, len(keys))
        if not self.campaign.correlations:
            return shares
        matrix = np.eye(len(keys))
        for i, correlation in enumerate(self.campaign.correlations):
            for key in correlation.of:
                if key not in keys:
                    where = self.where("correlations", i, "of")
                    self.problems.append(
                        Problem("not drawn", where=where, got=repr(key), expected=nearest(key, keys))
                    )
            if not self.problems:
                a, b = (keys.index(key) for key in correlation.of)
                matrix[a, b] = matrix[b, a] = correlation.value if a != b else 1.0
        if self.campaign.design.method == "saltelli":
            where, expected = self.where("correlations"), "independent values for Sobol indices"
            self.problems.append(Problem("saltelli has no correlations", where=where, expected=expected))
        if self.problems:
            return shares
        try:
            return correlated(shares, matrix)
        except np.linalg.LinAlgError:
            where = self.where("correlations")
            expected = "a positive definite matrix"
            self.problems.append(
                Problem("correlations that contradict each other", where=where, expected=expected)
            )
            return shares

    def _listed(self, key: str, v: Vary, change: Conversion) -> Array | None:
        """Values of a list, typed and converted; None for a distribution."""
        given = points(v)
        if given is None:
            return None
        typed = [_typed(value) for value in given]
        if any(value is None for value in typed):
            self._add("no value", key, v.kind, expected="numbers, texts, true or false")
            return None
        if v.unit is not None:
            if not all(_is_number(value) for value in typed):
                self._add("no unit for values that are no numbers", key, "unit", got=v.unit)
                return None
            typed = [change.of(float(value)) for value in typed]
        return _array(typed)

    def _converted(self, v: Vary, values: Array, change: Conversion) -> Array:
        if v.integers is not None and change.is_identity:
            return values.astype(np.int64)
        return change.factor * values + change.offset if change.is_scaled else values

    def _link(self, linked: Mapping[str, Vary]) -> None:
        """Compute the values that follow from others, each after those that it needs."""
        formulas = {key: self._formula(key, v) for key, v in linked.items()}
        waiting = {key: formula for key, formula in formulas.items() if formula is not None}
        while waiting and not self.problems:
            ready = [key for key, formula in waiting.items() if not set(formula.names) & set(waiting)]
            if not ready:
                for key in waiting:
                    self._add(
                        "needs itself", key, got=" and ".join(waiting), expected="links without a circle"
                    )
                return
            for key in ready:
                self._compute(key, linked[key], waiting.pop(key))

    def _formula(self, key: str, v: Vary) -> Expression | None:
        kind = v.kind
        try:
            if v.expression is not None:
                return expression(v.expression)
            return Expression(str(v.same_as), expression("0").tree, (str(v.same_as),))
        except ValueError as error:
            what, _, expected = str(error).partition(", expected ")
            self._add(what, key, kind, got=repr(v.expression), expected=expected)
            return None

    def _compute(self, key: str, v: Vary, formula: Expression) -> None:
        known: dict[str, Array] = {}
        for name in formula.names:
            try:
                known[name] = self.found[name] if name in self.found else self._constant(name)
            except ValueError as error:
                problem = error.args[0]
                assert isinstance(problem, Problem)
                self.problems.append(problem.at(self.where("vary", key, v.kind)))
        if self.problems:
            return
        if v.same_as is not None:
            self._copy(key, v, known[v.same_as])
            return
        wrong = [name for name, values in known.items() if values.dtype.kind not in "fi"]
        if wrong:
            self._add("no number", key, v.kind, got=", ".join(wrong), expected="signals that are numbers")
            return
        change = self._conversion(key, v)
        rows = zip(*(known[name].tolist() for name in formula.names), strict=True) if known else ()
        try:
            values = [formula.value(dict(zip(formula.names, row, strict=True))) for row in rows]
        except ValueError as error:
            self._add(str(error), key, v.kind, expected="a finite value in all runs")
            return
        if not known:
            values = [formula.value({})] * self.n_runs
        self.found[key] = self._converted(v, np.array(values), change)

    def _copy(self, key: str, v: Vary, source: Array) -> None:
        """Let a value be that of another signal, in its own unit, times a factor plus an offset."""
        is_number = source.dtype.kind in "fi"
        is_plain = v.factor == 1.0 and v.offset == 0.0
        own = self.targets[key].unit
        other = self._unit_of(str(v.same_as))
        change = conversion(other, own)
        if change is None:
            names = [u.name for u in (other, own) if u is not None]
            self._add(
                "another quantity", key, "same_as", got=" -> ".join(names), expected="the same quantity"
            )
        elif not is_number and not is_plain:
            self._add(
                "no number", key, "same_as", got=repr(v.same_as), expected="a number for factor or offset"
            )
        elif is_plain and change.is_identity:
            self.found[key] = source
        else:
            scaled = change.factor * source + change.offset if change.is_scaled else source
            self.found[key] = scaled if is_plain else v.factor * scaled + v.offset

    def _unit_of(self, name: str) -> Unit | None:
        found = self.targets.get(name)
        return self.base.unit(name) if found is None else found.unit

    def _constant(self, name: str) -> Array:
        return _array([self.base.value(name)] * self.n_runs)


def _typed(value: Any) -> Any:
    """Read a plain text as what it says: a number, true or false, else a text; lists part by part."""
    if isinstance(value, list):
        return [_typed(part) for part in value]
    if not isinstance(value, Plain):
        return value
    if value.is_null:
        return None
    for reading in (number_of, boolean_of):
        try:
            return reading(value)
        except ValueError:
            continue
    return str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _array(values: Sequence[Any]) -> Array:
    """Return an array of numbers or truths where all are such, else of objects; shape (n,)."""
    if all(isinstance(v, bool) for v in values):
        return np.array(values, dtype=bool)
    if all(isinstance(v, int) and not isinstance(v, bool) and abs(v) < 2**62 for v in values):
        return np.array(values, dtype=np.int64)
    if all(_is_number(v) for v in values):
        return np.array(values, dtype=np.float64)
    found = np.empty(len(values), dtype=object)
    found[:] = list(values)
    return found
