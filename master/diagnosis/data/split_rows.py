"""The compared rows of recordings, split as a case says."""

from __future__ import annotations

from collections.abc import Mapping

from master.diagnosis.case.case import LoadedCase
from master.diagnosis.case.split import (
    PARTS,
    Split,
    by_blocks,
    by_recording,
    over_pieces,
    with_sealed_recordings,
)
from master.errors import ConfigError, DataError

from .recordings import Recording

FEWEST_OF_STRETCH = 20  # rows next to a gap


def split_of(loaded: LoadedCase, recordings: Mapping[str, Recording]) -> Split:
    """
    Split the compared rows of the recordings as a case says.

    Raises:
        ConfigError: With every fault of the split.
    """
    entry = loaded.case.split
    cut = loaded.case.replay.cut
    every = loaded.case.replay.decimate
    pieces: dict[str, dict[str, int]] = {}
    for name, r in recordings.items():
        pieces.setdefault(r.entry or name, {})[name] = -(-(len(r) - 2 * cut) // every)
    lengths = {name: sum(own.values()) for name, own in pieces.items()}
    row_period = next(iter(recordings.values())).period * every
    guard = round(entry.guard / row_period)
    try:
        if entry.blocks is None:
            split = by_recording(lengths, {p: getattr(entry, p) for p in PARTS})
        elif entry.sealed:
            split = with_sealed_recordings(lengths, entry.blocks, guard, entry.sealed)
        else:
            split = by_blocks(lengths, entry.blocks, guard)
    except DataError as error:
        raise ConfigError(f"{loaded.where('split')}: {line}" for line in str(error).splitlines()) from None
    return over_pieces(split, pieces, max(guard, FEWEST_OF_STRETCH))
