from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from master.diagnosis.case.cut import MeasuredInput
from master.diagnosis.replay.slot_signals import slot_signals


def test_what_drives_a_foreign_file_is_there_to_be_tested():
    push = np.arange(5.0)
    part = SimpleNamespace(fmus=("box",), inputs={"box": {"u": MeasuredInput("push", "end")}})
    bench = SimpleNamespace(part=part, record=lambda *_: {"box.y": push}, signal={"push": push}.get)
    system = SimpleNamespace(model=lambda _: None)

    assert slot_signals(system, bench, None, {}) == {"box.u": {"value": push}}
