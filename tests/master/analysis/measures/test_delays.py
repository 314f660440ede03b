"""Growth over a delay, against roots by hand."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from master.analysis.measures.delays import MOST_STEPS, ExtraDelay, fastest_with_delays
from master.analysis.measures.margins import margin
from master.analysis.measures.sweep import parse_axis, stability_map
from master.errors import ConfigError
from tests.master.analysis.loops_of_stubs import linearisation_of
from tests.stubs import Block, bench, gain, integrator, variables, wire

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


def fastest_with_delay(coupled, wire, delay):
    return fastest_with_delays(coupled, [ExtraDelay(wire, delay)])


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


@pytest.mark.parametrize("d", [(0.0, 0.0), (0.0, 2.5), (1.0, 3.0), (0.25, 1.5), (2.999, 0.1), (7.3, 4.6)])
@pytest.mark.parametrize("p", [0.5, 1.7])
def test_two_delays_in_one_loop_of_gains_add_up(gains, p, d):
    delays = [ExtraDelay(wire, own * STEP) for wire, own in zip(gains.system.wires, d, strict=True)]
    found = fastest_with_delays(gains.coupled({"a.p": p}), delays)

    assert found.growth == pytest.approx(math.log(p) / ((1.0 + sum(d)) * STEP), rel=1e-9)


@pytest.fixture
def two_loops():
    """x(k + 1) = x(k) + h u(k), u = -0.3 x - 0.2 x, over a wire each: z - 1 + 0.3 z^-d + 0.2 z^-e = 0."""
    ports = variables(("u", "input"), ("w", "input"), ("y", "output"))
    adding = Block(lambda t, h, v: {"y": -0.3 * v["u"] - 0.2 * v["w"]}, ports, {"y": ("u", "w")})
    wires = [wire("a.x", "b.u"), wire("a.x", "b.w"), wire("b.y", "a.u")]
    return linearisation_of(bench({"a": integrator(), "b": adding}, wires, ["b", "a"]))


@pytest.mark.parametrize("halves", [(1, 4), (3, 5), (6, 1), (9, 9), (4, 7)])
def test_two_delays_in_two_loops_have_the_poles_of_a_polynomial_in_the_root_of_z(two_loops, halves):
    """With z = w^2 half steps are integers; roots with Re w < 0 belong to z on the other side of its cut."""
    longest = max(halves)
    polynomial = np.zeros(longest + 3)
    polynomial[0] = 1.0
    for power, factor in zip((0, *halves), (-1.0, 0.3, 0.2), strict=True):
        polynomial[2 + power] += factor
    w = np.roots(polynomial)
    expected = math.log(max(abs(w[w.real >= 0.0])) ** 2) / STEP
    delays = [
        ExtraDelay(wire, 0.5 * n * STEP) for wire, n in zip(two_loops.system.wires, halves, strict=False)
    ]

    assert fastest_with_delays(two_loops.coupled(), delays).growth == pytest.approx(expected, rel=1e-8)


def test_whole_steps_of_two_delays_are_those_of_the_system_with_values_under_way(integrating):
    from master.analysis.measures.poles import fastest

    [to_b, to_a] = integrating.system.wires
    for n, m in itertools.product(range(4), repeat=2):
        expected = fastest(integrating.coupled(extra={to_b.target.name: n, to_a.target.name: m}))
        delays = [ExtraDelay(to_b, n * STEP), ExtraDelay(to_a, m * STEP)]

        assert fastest_with_delays(integrating.coupled(), delays) == pytest.approx(expected, rel=1e-9)


def test_a_map_of_delay_against_delay_has_its_boundary_where_their_sum_is_the_margin(integrating):
    bound = margin(integrating.coupled(), integrating.system.wires[0]).delay
    axes = [parse_axis(f"{name}.u=0:8:5", integrating.system) for name in "ab"]
    found = stability_map(integrating, *axes)

    assert len(found.boundary) >= 4
    assert [x + y for x, y in found.boundary] == [pytest.approx(bound, rel=1e-5)] * len(found.boundary)
    assert [axis.own for axis in (found.x, found.y)] == [0.0, 0.0]


def test_one_delay_on_both_axes_is_refused(gains):
    axis = parse_axis("a.u=0:1:2", gains.system)
    with pytest.raises(ConfigError, match="the same twice"):
        stability_map(gains, axis, axis)
