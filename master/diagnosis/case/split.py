"""Fit, select and sealed test: by recording, or by blocks of one recording with guard gaps between them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from master.errors import DataError

PARTS = ("fit", "select", "sealed")


@dataclass(frozen=True)
class Stretch:
    """Rows `begin` to `end` (not included) of a recording."""

    recording: str
    begin: int
    end: int

    def __len__(self) -> int:
        return self.end - self.begin

    @property
    def rows(self) -> slice:
        """The rows as a slice."""
        return slice(self.begin, self.end)


class _Block(NamedTuple):
    """Rows `begin` to `end` (not included) for one use."""

    use: str
    begin: int
    end: int


class Sealed:
    """The sealed stretches; they are given out once."""

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        self._stretches: tuple[Stretch, ...] | None = tuple(stretches)

    def open(self) -> tuple[Stretch, ...]:
        """Break the seal. Raises RuntimeError if it is broken already."""
        if self._stretches is None:
            raise RuntimeError("the sealed part was read before, expected to read it once, at the end")
        stretches = self._stretches
        self._stretches = None
        return stretches


@dataclass(frozen=True)
class Split:
    """Stretches to fit on, to select by, and to judge by."""

    fit: tuple[Stretch, ...]
    select: tuple[Stretch, ...]
    sealed: Sealed


def by_recording(lengths: Mapping[str, int], parts: Mapping[str, Sequence[str]]) -> Split:
    """
    Split by whole recordings.

    Args:
        lengths: Rows of each recording.
        parts: Names of recordings for `fit`, `select`, `sealed`.

    Raises:
        DataError: With every fault.
    """
    used = [name for part in PARTS for name in parts.get(part, ())]
    problems = [f"split.{p}: got no recording, expected at least one" for p in PARTS if not parts.get(p)]
    problems += [
        f"split: no such recording, got {n!r}, expected one of {[*lengths]}" for n in used if n not in lengths
    ]
    problems += [
        f"split: {n!r} is there twice, expected once" for n in sorted({n for n in used if used.count(n) > 1})
    ]
    if problems:
        raise DataError("\n".join(problems))
    fit, select, sealed = (tuple(Stretch(n, 0, lengths[n]) for n in parts[part]) for part in PARTS)
    return Split(fit, select, Sealed(sealed))


def by_blocks(
    lengths: Mapping[str, int], pattern: Sequence[str], guard: int, needed: Sequence[str] = PARTS
) -> Split:
    """
    Cut every recording into equal blocks.

    Args:
        lengths: Rows of each recording.
        pattern: What each block is for, in time order: `fit`, `select` or `sealed`.
        guard: Rows left out between blocks of different use.
        needed: Parts that must have a block.

    Raises:
        DataError: If a needed part has no block or a block is shorter than the guard.
    """
    problems = [f"split.pattern: got {p!r}, expected one of {[*PARTS]}" for p in pattern if p not in PARTS]
    problems += [
        f"split.pattern: got no block for {p!r}, expected at least one" for p in needed if p not in pattern
    ]
    uses: dict[str, list[Stretch]] = {part: [] for part in PARTS}
    for name, n in lengths.items():
        for use, begin, end in _joined(pattern, n):
            inner = Stretch(name, begin + (guard if begin else 0), end)
            if inner.end - inner.begin <= guard:
                problems.append(f"block {begin}..{end} of {name!r} is too short for a guard of {guard} rows")
            uses.setdefault(use, []).append(inner)
    if problems:
        raise DataError("\n".join(problems))
    return Split(tuple(uses["fit"]), tuple(uses["select"]), Sealed(uses["sealed"]))


def with_sealed_recordings(
    lengths: Mapping[str, int], pattern: Sequence[str], guard: int, sealed: Sequence[str]
) -> Split:
    """
    Cut recordings into blocks, but for those that are sealed as a whole; see `by_blocks`.

    Raises:
        DataError: If a part has no block or a block is shorter than the guard.
    """
    cut = {name: n for name, n in lengths.items() if name not in sealed}
    split = by_blocks(cut, pattern, guard, needed=("fit", "select"))
    whole = [Stretch(n, 0, lengths[n]) for n in sealed]
    return Split(split.fit, split.select, Sealed([*split.sealed.open(), *whole]))


def over_pieces(split: Split, pieces: Mapping[str, Mapping[str, int]], least: int) -> Split:
    """
    Take the stretches of recordings to their pieces between gaps.

    Args:
        split: Of recordings, as if the pieces of each had no gap between them.
        pieces: Recording to its pieces in time order and their rows.
        least: Rows below which a stretch is left out.
    """
    fit, select, sealed = (
        tuple(cut for s in stretches for cut in _over_pieces(s, pieces[s.recording], least))
        for stretches in (split.fit, split.select, split.sealed.open())
    )
    return Split(fit, select, Sealed(sealed))


def _over_pieces(s: Stretch, pieces: Mapping[str, int], least: int) -> Iterator[Stretch]:
    first = 0
    for name, n in pieces.items():
        begin = max(s.begin - first, 0)
        end = min(s.end - first, n)
        if end - begin >= least or (end > begin and len(pieces) == 1):
            yield Stretch(name, begin, end)
        first += n


def blocks(stretches: Sequence[Stretch], n: int) -> list[Stretch]:
    """Cut stretches into about n contiguous blocks of about equal length."""
    total = sum(map(len, stretches))
    cut = []
    for s in stretches:
        count = max(1, round(n * len(s) / total))
        edges = [s.begin + len(s) * i // count for i in range(count + 1)]
        cut += [Stretch(s.recording, a, b) for a, b in itertools.pairwise(edges)]
    return cut


def _joined(pattern: Sequence[str], n: int) -> list[_Block]:
    """Cut n rows into equal blocks; neighbours of one use are one block."""
    edges = [n * i // len(pattern) for i in range(len(pattern) + 1)]
    joined: list[_Block] = []
    for use, begin, end in zip(pattern, edges[:-1], edges[1:], strict=True):
        if joined and joined[-1].use == use:
            joined[-1] = joined[-1]._replace(end=end)
        else:
            joined.append(_Block(use, begin, end))
    return joined
