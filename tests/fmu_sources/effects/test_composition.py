"""A composed model is the base with the law inside its equations."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmu_sources.composed.composition import with_effect
from fmu_sources.effects.catalogue import candidates, effect
from fmu_sources.effects.framework.effect import Applied, Effect, Rms
from fmu_sources.export.native.casadi_arithmetic import CASADI
from fmu_sources.export.units import si_exponents
from fmu_sources.framework.instance import Instance
from fmu_sources.framework.variables import parameter, sampled, state
from fmu_sources.motion_simulator import motion_simulator_linear

RMS = Rms(value=10.0, position=0.01, velocity=0.2, load=100.0, duration=1.0)


def run(model, n=400, **given):
    instance = Instance(model)
    for name, value in given.items():
        instance[name] = value
    instance.initialise()
    rows = []
    for k in range(n):
        instance["u"] = 3.0 * math.sin(0.04 * k)
        instance.step(k * 1e-3, 1e-3)
        rows.append([instance["y"], instance["der_y"], instance["f"], instance["command"]])
    return np.array(rows)


def all_pairs(model):
    return [(slot.name, e.name) for slot in model.slots for e in candidates(slot)]


def test_names_come_from_the_parts(oscillator):
    model = with_effect(oscillator, "spring", effect("coulomb"))
    model = with_effect(model, "sensor", effect("extra_lag"))

    assert model.name == "small__spring_coulomb_and_sensor_extra_lag"
    assert [v.name for v in model.all_variables if v.name.startswith(("spring", "sensor"))] == [
        "spring_coulomb_level",
        "spring_coulomb_smoothing",
        "sensor_extra_lag_time_constant",
        "sensor_extra_lag_lagged",
    ]
    units = {v.name: v.unit for v in model.all_variables}
    assert units["spring_coulomb_smoothing"] == "m/s"
    assert units["sensor_extra_lag_lagged"] == "N"


def test_start_values_go_to_the_declarations(oscillator):
    model = with_effect(oscillator, "spring", effect("coulomb"), starts={"level": 7.0})

    assert Instance(model)["spring_coulomb_level"] == 7.0


def test_faults_name_what_there_is(oscillator):
    with pytest.raises(ValueError, match="no such slot, got 'rope', expected one of"):
        with_effect(oscillator, "rope", effect("coulomb"))
    with pytest.raises(ValueError, match="coulomb does not fit, got signals"):
        with_effect(oscillator, "sensor", effect("coulomb"))
    with pytest.raises(ValueError, match="prefix is taken"):
        with_effect(with_effect(oscillator, "spring", effect("dahl")), "spring", effect("dahl"))


def test_every_fitting_effect_of_zero_size_is_the_base(oscillator):
    base = run(oscillator, 60)
    for slot, name in all_pairs(oscillator):
        model = with_effect(oscillator, slot, effect(name), starts=effect(name).absent)
        assert np.array_equal(base, run(model, 60)), (slot, name)


def test_every_fitting_effect_traces_to_symbols(oscillator):
    for slot, name in all_pairs(oscillator):
        model = with_effect(oscillator, slot, effect(name))
        x, u, p = (
            kind.record([casadi.SX.sym(n) for n in kind.names])
            for kind in (model.states, model.inputs, model.parameters)
        )
        t = casadi.SX.sym("t")
        for equation, kind in (("derivatives", model.continuous), ("outputs", model.results)):
            traced = kind.flat(getattr(model, equation)(t, x, u, p, CASADI))
            assert all(isinstance(expression, (casadi.SX, float)) for expression in traced), (slot, name)
        model.update(t, x, u, p, CASADI)
        model.initial(x, u, p, CASADI)


def test_states_advance_once_though_the_slot_is_called_in_two_equations(oscillator):
    model = with_effect(oscillator, "spring", effect("dahl"), starts={"level": 5.0, "length": 2e-3})
    found = run(model)

    def law(t, z):
        y, v, share = z
        force = 800.0 * y + 4.0 * v + 5.0 * share
        u = 3.0 * math.sin(0.04 * math.floor(t / 1e-3 + 1e-6))
        return [v, (u - force) / 2.0, (v - abs(v) * share) / 2e-3]

    z = np.array([0.02, 0.0, 0.0])
    for k in range(400):
        span = (k * 1e-3, k * 1e-3 + 1e-3)
        z = solve_ivp(lambda t, z, t0=span[0]: law(t0, z), span, z, rtol=1e-10, atol=1e-13).y[:, -1]

    assert found[-1, :2] == pytest.approx(z[:2], abs=1e-7)


@pytest.mark.parametrize(
    ("slot", "name", "starts", "force"),
    [
        ("spring", "coulomb", {"level": 4.0, "smoothing": 5e-3}, lambda y, v: 4.0 * math.tanh(v / 5e-3)),
        ("spring", "cubic_stiffness", {"coefficient": 1e6}, lambda y, v: 1e6 * y**3),
        ("spring", "quadratic_damping", {"coefficient": 20.0}, lambda y, v: 20.0 * v * abs(v)),
        (
            "spring",
            "end_stop",
            {"limit": 0.01, "stiffness": 900.0},
            lambda y, v: 900.0 * math.copysign(max(abs(y) - 0.01, 0.0), y),
        ),
        (
            "spring",
            "load_friction",
            {"coefficient": 0.05, "smoothing": 5e-3},
            lambda y, v: 0.05 * abs(100.0 + 1000.0 * y) * math.tanh(v / 5e-3),
        ),
    ],
)
def test_motion_agrees_with_an_independent_solver(oscillator, slot, name, starts, force):
    instance = Instance(with_effect(oscillator, slot, effect(name), starts=starts))
    instance.initialise()
    for k in range(500):
        instance.step(k * 1e-3, 1e-3)

    def law(t, z):
        return [z[1], -(800.0 * z[0] + 4.0 * z[1] + force(*z)) / 2.0]

    exact = solve_ivp(law, (0.0, 0.5), [0.02, 0.0], rtol=1e-11, atol=1e-14, max_step=1e-3).y[:, -1]
    assert [instance["y"], instance["der_y"]] == pytest.approx(exact, abs=2e-7)


def test_lag_of_the_output_is_that_of_an_independent_solver(oscillator):
    instance = Instance(
        with_effect(oscillator, "sensor", effect("extra_lag"), starts={"time_constant": 0.02})
    )
    instance.initialise()
    assert instance["f"] == pytest.approx(16.0)  # at rest behind the filter: k y
    for k in range(300):
        instance.step(k * 1e-3, 1e-3)

    def law(t, z):
        f = 800.0 * z[0] + 4.0 * z[1]
        return [z[1], -f / 2.0, (f - z[2]) / 0.02]

    exact = solve_ivp(law, (0.0, 0.3), [0.02, 0.0, 16.0], rtol=1e-11, atol=1e-14).y[2, -1]
    assert instance["f"] == pytest.approx(exact, abs=1e-6)


def test_dead_time_of_the_output_delays_it(oscillator):
    base = run(oscillator)[:, 2]
    delayed = run(with_effect(oscillator, "sensor", effect("extra_delay"), starts={"dead_time": 5e-3}))[:, 2]

    assert delayed[200:] == pytest.approx(base[195:395], abs=2e-3 * np.abs(base).max())


def test_lag_in_a_sampled_slot_sees_what_the_controller_holds(oscillator):
    lagged = run(
        with_effect(oscillator, "controller", effect("extra_lag"), starts={"time_constant": 5e-3}), 50
    )
    z, expected = 0.0, []
    for k in range(50):
        u = 3.0 * math.sin(0.04 * k)
        expected.append(z)
        z += (u - z) * (1.0 - math.exp(-0.2))  # exact solution for a held input

    assert lagged[:, 3] == pytest.approx(expected, abs=1e-6)


def test_stacked_effects_work_one_behind_the_other(oscillator):
    model = with_effect(oscillator, "sensor", effect("offset"), starts={"offset": 2.0})
    model = with_effect(model, "sensor", effect("gain_error"), starts={"error": 0.5})

    assert run(model, 5)[:, 2] == pytest.approx(1.5 * (run(oscillator, 5)[:, 2] + 2.0))


def test_clearance_behind_presliding_lies_in_the_joint(oscillator):
    model = with_effect(
        oscillator, "spring", effect("presliding"), starts={"stiffness": 1e3, "forward": 5.0, "backward": 5.0}
    )
    model = with_effect(model, "spring", effect("clearance"), starts={"gap": 1.0, "stiffness": 1e3})

    assert run(model)[:, 0] == pytest.approx(run(oscillator)[:, 0], abs=1e-12)


def test_sampled_states_of_an_effect_change_once_a_period(oscillator):
    last = Effect(
        name="last",
        description="The value one period ago",
        law=lambda t, value, s, x, p, m: Applied(x.last, {"last": value}),
        parameters=(parameter("nothing", 0.0, "1", "No use"),),
        states=(sampled(state("last", "{value}", "Last value")),),
        absent={},
        scale=lambda _: {},
        follows=("last",),
    )
    base = run(oscillator, 20)

    assert run(with_effect(oscillator, "controller", last), 20)[1:, 3] == pytest.approx(base[:-1, 3])
    assert run(with_effect(oscillator, "sensor", last), 20)[1:, 2] == pytest.approx(base[:-1, 2])


def test_unit_of_a_rate_in_a_slot_of_velocity_has_one_slash():
    model = with_effect(motion_simulator_linear.MODEL, "velocity_command", effect("rate_saturation"))
    limit = next(v for v in model.variables if v.name == "velocity_command_rate_saturation_limit")

    assert si_exponents(limit.unit) == {"m": 1, "s": -2}
