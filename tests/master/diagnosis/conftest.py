"""Studies of which the replays are formulas, for tests of what is decided on them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.search.study import Study


@pytest.fixture
def study_of():
    """Make a study of a measurement (rows, outputs) with held-out blocks; `changed` are other fields."""

    def make(measured, held_out, **changed):
        given = {
            "system": None,
            "bench": SimpleNamespace(measured=measured, name="part"),
            "pool": SimpleNamespace(build=lambda models, progress: None),
            "base": (),
            "fit_rows": np.ones(len(measured), dtype=bool),
            "held_out": tuple(held_out),
            "progress": lambda text: None,
            "output_scale": np.ones(measured.shape[1]),
            "slot_values": {},
        }
        return Study(**given | changed)

    return make
