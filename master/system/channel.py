"""What a scenario may do to the value of a connection on its way: codes of its state, columns of its row."""

from __future__ import annotations

PASS, FREEZE, DROP = range(3)
MODE, OFFSET, DELAY, JITTER, FALLBACK, RANDOM, DRAWN, MORE, HELD = range(9)
