"""Stages of a diagnosis: what each model leaves in every channel, judged alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from master.diagnosis.adequacy.channels import Adequacy

REFIT = "refit"


@dataclass(frozen=True)
class Stage:
    """A model by the name of what was added last, and what it leaves in each channel."""

    name: str
    channels: tuple[Adequacy, ...]

    @property
    def is_adequate(self) -> bool:
        """Whether nothing is left in any channel that the channel could tell."""
        return all(c.is_adequate for c in self.channels)

    @property
    def is_noise(self) -> bool:
        """Whether hardly more is left than the noise of the channels, and nothing predicts it."""
        return self.is_quiet and all(c.is_within_floor for c in self.channels)

    @property
    def is_quiet(self) -> bool:
        """Whether it is adequate, and not even rounding can be predicted, which may be a converter's."""
        return self.is_adequate and all(c.is_unpredicted for c in self.channels)

    @property
    def is_predictable(self) -> bool:
        """Whether something recorded still predicts what is left in a channel."""
        return any(c.is_predictable for c in self.channels)

    @property
    def worst(self) -> Adequacy:
        """The channel of which most is predictable; of silent ones, that with most over its floor."""
        loud = [c for c in self.channels if c.is_predictable]
        if loud:
            return max(loud, key=lambda c: c.share.value)
        return max(self.channels, key=lambda c: c.ratio)


def of_channel(stages: Sequence[Stage], signal: str) -> list[Adequacy]:
    """Adequacy of one channel along the stages."""
    return [c for stage in stages for c in stage.channels if c.signal == signal]
