"""Margins against closed forms and against whole steps of delay."""

from __future__ import annotations

import math

import pytest

from master.analysis.measures.margins import margins
from master.analysis.measures.poles import growth_rate
from tests.master.analysis.loops_of_stubs import linearisation_of
from tests.stubs import bench, gain, integrator, wire

STEP = 1e-3
RATE = 20.0


@pytest.fixture
def loop():
    """X' = -20 x(t - tau): unstable from tau = pi/2/20 = 78.5 ms on; the explicit step costs half a step."""
    wires = [wire("damper.y", "sum.u"), wire("sum.x", "damper.u")]
    made = bench({"sum": integrator(), "damper": gain(-RATE)}, wires, ["sum", "damper"], step_size=STEP)
    return linearisation_of(made)


def test_the_delay_margin_of_a_first_order_loop_is_a_quarter_period(loop):
    angle = 2.0 * math.asin(0.5 * RATE * STEP)  # |z - 1| = 20 h
    exact = STEP * (0.5 * math.pi - 0.5 * angle) / angle

    for margin in margins(loop.coupled()):
        assert margin.delay == pytest.approx(exact, abs=1e-9)
        assert margin.frequency == pytest.approx(angle / (2.0 * math.pi * STEP), rel=1e-6)


def test_whole_steps_on_both_sides_of_the_margin_are_stable_and_unstable(loop):
    ticks = math.floor(margins(loop.coupled())[0].delay / STEP)

    assert growth_rate(loop.coupled(extra={"sum.u": ticks})) < 0.0
    assert growth_rate(loop.coupled(extra={"sum.u": ticks + 1})) > 0.0


def test_the_gain_margin_of_an_explicit_step_is_two_over_its_rate(loop):
    [margin, _] = margins(loop.coupled())

    assert margin.gain_up == pytest.approx(2.0 / (RATE * STEP), rel=1e-6)
    assert margin.gain_down is None


def test_an_unstable_system_has_no_margins(oscillator):
    assert margins(oscillator(0.87, 20).coupled()) == []
