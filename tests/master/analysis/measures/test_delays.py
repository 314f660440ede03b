"""Growth over a delay, against roots by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from master.analysis.measures.delays import MOST_STEPS, fastest_with_delay
from master.analysis.measures.margins import margin
from master.analysis.measures.sweep import parse_axis, stability_map
from master.errors import ConfigError
from tests.master.analysis.loops_of_stubs import linearisation_of
from tests.stubs import bench, gain, integrator, variables, wire

STEP = 1.0  # s, of a bench of stubs


@pytest.fixture
def gains():
    """x(k + 1) = p x(k): with d steps more z^(1 + d) = p, growth log(p)/((1 + d) h)."""
    parameter = variables(("p", "parameter", {"variability": "fixed", "start": "0.5"}))
    block = gain()
    ports = block.variables + tuple(replace(v, reference=len(block.variables)) for v in parameter)
    scaled = replace(block, variables=ports, law=lambda t, h, v: {"y": v["p"] * v["u"]})
    return linearisation_of(
        bench({"a": scaled, "b": gain()}, [wire("a.y", "b.u"), wire("b.y", "a.u")], ["a", "b"])
    )


@pytest.fixture
def integrating():
    """x(k + 1) = x(k) + h u(k), u = -0.3 x: with d steps more z - 1 + 0.3 z^-d = 0."""
    taking = replace(gain(), law=lambda t, h, v: {"y": -0.3 * v["u"]})
    return linearisation_of(
        bench({"a": integrator(), "b": taking}, [wire("a.x", "b.u"), wire("b.y", "a.u")], ["b", "a"])
    )


@pytest.mark.parametrize("p", [0.5, 1.7])
@pytest.mark.parametrize("d", [0.0, 0.25, 1.0, 1.5, 2.999, 7.3])
def test_the_growth_of_a_loop_of_gains_is_that_by_hand(gains, p, d):
    coupled = gains.coupled({"a.p": p})
    found = fastest_with_delay(coupled, gains.system.wires[0], d * STEP)

    assert found.growth == pytest.approx(math.log(p) / ((1.0 + d) * STEP), rel=1e-9)


def test_whole_steps_are_those_of_the_system_with_values_under_way(integrating):
    from master.analysis.measures.poles import fastest

    [to_b, _] = integrating.system.wires
    for n in range(9):
        expected = fastest(integrating.coupled(extra={to_b.target.name: n}))
        found = fastest_with_delay(integrating.coupled(), to_b, n * STEP)

        assert found == pytest.approx(expected, rel=1e-9)


def test_growth_is_continuous_over_the_delay_and_zero_at_the_margin(integrating):
    """The margin is found on the unit circle, without poles; by hand w = 2 asin 0.15, d = (pi - w)/(2 w)."""
    coupled, [to_b, _] = integrating.coupled(), integrating.system.wires
    delays = np.linspace(0.0, 8.0, 81) * STEP
    growth = np.array([fastest_with_delay(coupled, to_b, d).growth for d in delays])
    bound = margin(coupled, to_b).delay
    w = 2.0 * math.asin(0.15)

    assert bound == pytest.approx((math.pi - w) / (2.0 * w) * STEP, rel=1e-6)
    assert np.max(np.abs(np.diff(growth[8:]))) < 0.12  # from where two real poles have met
    assert fastest_with_delay(coupled, to_b, bound).growth == pytest.approx(0.0, abs=1e-9)
    found = stability_map(integrating, parse_axis("b.u=0:8:9", integrating.system))
    assert [x for x, _ in found.boundary] == [pytest.approx(bound, rel=1e-5)]


def test_a_delay_that_is_too_long_is_refused(gains):
    with pytest.raises(ConfigError, match=f"{MOST_STEPS} steps"):
        fastest_with_delay(gains.coupled(), gains.system.wires[0], 1e6)


def test_two_delays_are_refused(gains):
    axes = [parse_axis(f"{name}.u=0:1:2", gains.system) for name in "ab"]
    with pytest.raises(ConfigError, match="two delays"):
        stability_map(gains, *axes)
