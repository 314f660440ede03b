"""The matrix of a tick is the tick: against exact solutions and against the stepped stubs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import lambertw

from master.analysis.measures.margins import margin
from master.analysis.measures.poles import dominant, growth_rate, poles
from master.errors import FmuError
from tests.master.analysis.loops_of_stubs import STEP, linearisation_of
from tests.stubs import bench, gain, integrator, wire


def of_tick(linearisation, **more):
    """Eigenvalues of one period, largest first, zeros left out."""
    z = np.linalg.eigvals(linearisation.coupled(**more).matrix())
    return np.sort(np.abs(z[np.abs(z) > 1e-6]))[::-1]


@pytest.mark.parametrize(
    ("frequency", "ticks", "growth"),
    [(0.87, 20, 0.2965), (0.87, 50, 0.7124), (0.87, 100, 1.2631), (2.6, 50, 4.8408)],
)
def test_an_undamped_loop_with_a_pure_delay_grows_as_the_lambert_function_says(
    oscillator, frequency, ticks, growth
):
    exact = (2.0 / (ticks * STEP) * lambertw(1j * np.pi * frequency * ticks * STEP)).real

    found = growth_rate(oscillator(frequency, ticks).coupled())

    assert exact == pytest.approx(growth, abs=1e-4)
    assert found == pytest.approx(exact, abs=1e-3)


def test_a_tick_of_delay_more_is_one_of_the_connection(oscillator):
    extra = oscillator(0.87).coupled(extra={"mass.f": 20})

    assert growth_rate(extra) == pytest.approx(growth_rate(oscillator(0.87, 20).coupled()), abs=1e-9)


def test_the_symplectic_loop_neither_grows_nor_decays(oscillator):
    assert growth_rate(oscillator(0.87).coupled()) == pytest.approx(0.0, abs=1e-6)


def test_side_by_side_costs_a_step_and_grows(oscillator):
    w = 2.0 * np.pi * 0.87

    found = growth_rate(oscillator(0.87, order=[["mass", "spring"]]).coupled())

    assert found == pytest.approx(0.5 * w * w * STEP, rel=1e-2)


def test_a_loop_that_steps_every_second_tick_is_one_of_twice_the_step():
    def loop(step, every):
        wires = [wire("slow.y", "sum.u"), wire("sum.x", "slow.u")]
        rates = {"slow": every, "sum": every}
        blocks = {"sum": integrator(), "slow": gain(-3.0)}
        return linearisation_of(bench(blocks, wires, ["sum", "slow"], step_size=step, every=rates))

    assert of_tick(loop(0.05, 2))[0] == pytest.approx(of_tick(loop(0.1, 1))[0], abs=1e-9)
    assert of_tick(loop(0.1, 1))[0] == pytest.approx(0.7, abs=1e-9)


def test_an_iterated_loop_is_implicit():
    """x+ = x + h u with u = -3 x+ is x+ = x/(1 + 3 h): the integrator's own input, iterated to the end."""
    wires = [wire("damper.y", "sum.u"), wire("sum.x", "damper.u")]
    order = [{"iterate": ["sum", "damper"]}]
    made = bench({"sum": integrator(), "damper": gain(-3.0)}, wires, order, step_size=0.1)

    assert of_tick(linearisation_of(made))[0] == pytest.approx(1.0 / 1.3, abs=1e-9)


def test_an_extrapolated_input_uses_its_last_value():
    """x+ = x - 3 h (2 x - x_last): z^2 - (1 - 6 h) z - 3 h = 0."""
    wires = [wire("damper.y", "sum.u", extrapolation=1), wire("sum.x", "damper.u")]
    made = bench({"sum": integrator(), "damper": gain(-3.0)}, wires, ["damper", "sum"], step_size=0.1)

    exact = np.sort(np.abs(np.roots([1.0, -0.4, -0.3])))[::-1]
    assert of_tick(linearisation_of(made))[:2] == pytest.approx(exact, abs=1e-8)


def test_the_matrix_of_the_cut_loop_closed_again_is_the_matrix(oscillator):
    coupled = oscillator(0.87, 3).coupled()

    for wire_ in coupled.wires:
        opened = coupled.opened(wire_, cut=True)
        np.testing.assert_allclose(opened.M + opened.N @ opened.P, coupled.matrix(), atol=1e-12)


def test_a_connection_within_an_iterated_group_can_be_opened():
    """x+ = x + h u, v = -3 x+ with u = r: v = -3 x - 3 h r; closed again, r = v, the loop is implicit."""
    wires = [wire("damper.y", "sum.u"), wire("sum.x", "damper.u")]
    order = [{"iterate": ["sum", "damper"]}]
    coupled = linearisation_of(
        bench({"sum": integrator(), "damper": gain(-3.0)}, wires, order, step_size=0.1)
    ).coupled()
    into_sum = next(w for w in coupled.wires if w.target.name == "sum.u")

    opened = coupled.opened(into_sum, cut=True)
    found = margin(coupled, into_sum)

    assert opened.Q[0, 0] == pytest.approx(-0.3, abs=1e-9)
    np.testing.assert_allclose(opened.M + opened.N @ opened.P / 1.3, coupled.matrix(), atol=1e-9)
    assert found.gain_up is None


def test_mass_and_spring_take_part_in_the_oscillation(oscillator):
    found = dominant(poles(oscillator(0.87, 20).coupled()))

    shares = dict(found.parts)
    assert found.frequency == pytest.approx(0.86, abs=0.01)
    assert shares["mass"] == max(shares.values())
    assert sum(shares.values()) == pytest.approx(1.0, abs=0.25)


def test_an_fmu_that_cannot_save_its_state_is_refused(oscillator):
    linearisation = oscillator(0.87)
    for instance in linearisation.system.instances.values():
        object.__setattr__(instance.description, "can_get_and_set_state", False)

    with pytest.raises(
        FmuError, match=r"mass: cannot be analysed, got canGetAndSetFMUState = false, expected true"
    ):
        linearisation.coupled()
