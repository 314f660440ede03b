"""The undamped oscillator, coupled."""

from __future__ import annotations

import math

import pytest

from tests.master.analysis.loops_of_stubs import STEP, linearisation_of, mass
from tests.stubs import METRE, NEWTON, bench, gain, wire


@pytest.fixture
def oscillator():
    """Give the linearisation of a mass on a spring at a frequency [Hz], the force delayed by whole steps."""

    def make(frequency, delay=0, order=("mass", "spring"), **more):
        stiffness = (2.0 * math.pi * frequency) ** 2
        blocks = {"mass": mass(), "spring": gain(-stiffness, source=NEWTON, target=METRE)}
        wires = [wire("mass.x", "spring.u"), wire("spring.y", "mass.f", delay=delay)]
        start = {"mass": {"x": 0.01}}
        return linearisation_of(bench(blocks, wires, list(order), step_size=STEP, start=start, **more))

    return make
