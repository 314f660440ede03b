from __future__ import annotations

import math

import numpy as np
import pytest

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.motion_simulator.geometry import leg_lengths
from fmu_sources.motion_simulator.hexapod_variables import LIMITS
from fmu_sources.motion_simulator.motion_simulator import MODEL, MotionSimulator
from tests.fmu_sources.motion_simulator.hexapod import NEUTRAL, PARAMETERS, SAMPLE, at_rest, read, run

STATE_NAMES = [n for n in MODEL.states.names if not n.endswith("_time")]


def test_ports_are_those_of_the_rig():
    outputs = {v.base for v in MODEL.variables if v.output} | {
        name.partition("[")[0] for name in MODEL.results.names
    }

    assert {"pose_cmd", "wrench", "s_cmd", "f_contact"} == set(MODEL.inputs.fields)
    assert {"pose", "twist", "leg_length", "motor_current", "leg_force", "s_act", "v_act"} < outputs


def test_a_vector_names_the_units_of_its_elements():
    units = {v.name: v.unit for v in MODEL.variables}

    assert [units[f"pose_cmd[{i}]"] for i in (3, 4)] == ["m", "rad"]
    assert [units[f"wrench[{i}]"] for i in (3, 4)] == ["N", "N m"]
    assert [units[f"twist[{i}]"] for i in (3, 4)] == ["m/s", "rad/s"]


def test_pose_and_displacement_start_as_set():
    instance = Instance(MODEL)
    instance["s_act"], instance["roll_act"] = -0.01, 0.02
    instance.initialise()

    assert read(instance, "pose").tolist() == [0.0, 0.0, -0.01, 0.02, 0.0, 0.0]
    assert read(instance, "leg_length") == pytest.approx(
        leg_lengths((0.0, 0.0, -0.01, 0.02, 0.0, 0.0), PARAMETERS, PYTHON)
    )


def reachable_poses(n):
    random = np.random.default_rng(11)
    return [tuple(random.uniform(-1, 1, 6) * [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]) for _ in range(n)]


@pytest.mark.parametrize("pose", reachable_poses(3), ids=["a", "b", "c"])
def test_a_reachable_start_pose_is_held_for_a_second(pose):
    instance = at_rest(pose, f_contact=-300.0, **{"wrench[1]": 50.0, "wrench[5]": -20.0})
    for k in range(10):
        instance.step(k * 0.1, 0.1)

        assert np.abs(read(instance, "pose") - pose).max() <= 1e-9
    assert np.abs(read(instance, "twist")).max() <= 1e-9


def test_currents_at_the_start_carry_the_legs():
    instance = at_rest()
    K2_KT = 2 * math.pi / 0.02 * 0.55

    assert read(instance, "leg_force") == pytest.approx([1031.0] * 6, abs=0.5)
    assert K2_KT * read(instance, "motor_current") == pytest.approx(read(instance, "leg_force"))


def test_a_contact_force_pushes_the_platform_its_own_way():
    instance = at_rest()
    instance["f_contact"] = 300.0
    run(instance, 20)

    assert 1e-6 < instance["s_act"] < 1e-3
    other = at_rest()
    other["wrench[3]"] = 300.0
    run(other, 20)
    assert other["s_act"] == instance["s_act"]


@pytest.mark.parametrize("dead_time", [0.0, 2e-3, 20e-3])
def test_a_command_moves_the_platform_after_its_dead_time(dead_time):
    instance = at_rest(dead_time=dead_time)
    moved = run(instance, 30, lambda t: 1e-3) > 1e-9

    assert np.argmax(moved) == round(dead_time / SAMPLE)


def test_the_displacement_command_adds_to_the_commanded_pose():
    one, other = at_rest(), at_rest()
    one["s_cmd"], other["pose_cmd[3]"] = 0.005, 0.005

    assert run(one, 50).tolist() == run(other, 50).tolist()


def test_substeps_are_exact_to_10_nm():
    class Fine(MotionSimulator):
        substep = 0.05e-3

    def sine(t):
        return 0.01 * math.sin(2 * math.pi * 2.6 * t)

    error = np.abs(run(at_rest(), 400, sine) - run(at_rest(model=Fine()), 400, sine)).max()

    assert error < 1e-8


def test_error_falls_with_order_4():
    def end(h):
        class Stepped(MotionSimulator):
            substep = h

        return run(at_rest(model=Stepped()), 20, lambda t: 1e-3)[-1]  # below every limit

    reference = end(0.0625e-3)
    errors = [abs(end(h) - reference) for h in (0.5e-3, 0.25e-3)]

    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.7)


def test_voltage_and_current_stay_at_their_limits_and_say_so():
    instance = at_rest(i_max=8.0, V_max=50.0)
    assert not instance["voltage_saturated"]
    assert not instance["current_limited"]

    run(instance, 30, lambda t: 0.1)
    assert instance["current_limited"]
    # the current follows its limited reference within the P controller's error
    assert np.abs(read(instance, "motor_current")).max() < 8.0 + 1e-6


def test_a_limited_speed_controller_does_not_wind_up():
    instance = at_rest(i_max=8.0)
    run(instance, 1500, lambda t: 0.05)

    assert instance["s_act"] == pytest.approx(0.05, abs=1e-4)


def test_low_voltage_is_flagged():
    instance = at_rest(V_max=12.0)
    run(instance, 30, lambda t: 0.1)

    assert instance["voltage_saturated"]


def test_fast_legs_are_flagged():
    instance = at_rest(v_max=0.01)
    assert not instance["leg_velocity_exceeded"]

    run(instance, 100, lambda t: 0.05)
    assert instance["leg_velocity_exceeded"]


def test_a_leg_past_its_switch_is_flagged():
    assert not at_rest()["leg_stroke_exceeded"]
    assert at_rest((0.0, 0.0, 0.34, 0.0, 0.0, 0.0))["leg_stroke_exceeded"]


def flags(instance):
    return {name: bool(instance[name]) for name in LIMITS}


def test_a_flag_shows_what_a_substep_raised_within_a_period():
    """A jump of the command asks for a voltage that the current's rise of 0.5 ms takes back."""
    instance = at_rest(V_max=20.0, dead_time=0.0)
    instance["s_cmd"] = 0.25e-3
    model, p = instance.model, PARAMETERS._replace(V_max=20.0, dead_time=0.0)
    run(instance, 1, lambda t: 0.25e-3)
    x, u = (kind.record([instance[n] for n in kind.names]) for kind in (model.states, model.inputs))
    at_its_end = model.outputs(0.0, x._replace(voltage_saturated_time=0.0), u, p, PYTHON)

    assert not at_its_end["voltage_saturated"]
    assert instance["voltage_saturated"]
    run(instance, 1, lambda t: 0.25e-3)
    assert not instance["voltage_saturated"]


def test_a_long_step_shows_every_flag_of_its_periods():
    short, long = (at_rest(i_max=8.0, v_max=0.05, V_max=15.0) for _ in range(2))
    seen = dict.fromkeys(LIMITS, False)
    for k in range(400):
        short["s_cmd"] = 0.02
        short.step(k * SAMPLE, SAMPLE)
        seen = {name: seen[name] or raised for name, raised in flags(short).items()}
    long["s_cmd"] = 0.02
    long.step(0.0, 0.4)

    assert flags(long) == seen
    assert sum(seen.values()) == 3
    assert not any(flags(short).values())
    assert [long[n] for n in STATE_NAMES] == pytest.approx([short[n] for n in STATE_NAMES], rel=1e-12)
    long.step(0.4, 0.4)
    assert not any(flags(long).values())


def test_a_stop_that_is_passed_within_a_long_step_ends_the_run():
    """The integral of the speed controller brings the leg back long before the second has passed."""
    length = at_rest()["leg_length[1]"]
    instance = at_rest(l_max=length + 20e-6, stop_margin=0.0)
    free = at_rest()
    for one in (instance, free):
        one["f_contact"] = 5000.0
    free.step(0.0, 1.0)

    assert read(free, "leg_length").max() < length + 20e-6
    with pytest.raises(ModelError, match=r"leg_length\[1\]: leg 1 is past a stop, got 1\.50\d+ m"):
        instance.step(0.0, 1.0)
    assert instance.time < 0.1


def test_friction_in_a_leg_lames_its_own_leg_only():
    class Stiff(MotionSimulator):
        def derivatives(self, t, x, u, p, m, slot=None):
            def friction(name, value, l, der_l, load):  # noqa: E741
                return value + (2000.0 * m.tanh(der_l / 1e-3) if name == "leg_force_1" else 0.0)

            return super().derivatives(t, x, u, p, m, friction)

    instance = at_rest(model=Stiff())
    run(instance, 50, lambda t: 0.01)
    lengths = read(instance, "leg_length") - leg_lengths(NEUTRAL, PARAMETERS, PYTHON)

    assert np.argmin(lengths) == 0
    assert lengths[0] < 0.9 * lengths[1:].min()
