from __future__ import annotations

import math

import pytest

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.motion_simulator.geometry import leg_lengths
from fmu_sources.motion_simulator.motion_simulator import MODEL
from tests.fmu_sources.motion_simulator.hexapod import PARAMETERS, SAMPLE, at_rest, run

POSITIVE = (
    *("base_radius", "platform_radius", "height", "l_min", "l_max"),
    *("m_p", "I_x", "I_y", "I_z", "m_1", "I_1", "m_2", "I_2"),
    *("lead", "KT", "L", "Kpp", "Kvi", "Kc", "V_max", "i_max", "v_max"),
)


def started(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()


def test_an_unreachable_start_pose_names_the_leg_and_its_length():
    with pytest.raises(ModelError) as caught:
        started(s_act=0.5, x_act=0.2)

    lengths = leg_lengths((0.2, 0.0, 0.5, 0.0, 0.0, 0.0), PARAMETERS, PYTHON)
    expected = "expected between l_min - stop_margin and l_max + stop_margin"
    assert str(caught.value).split("; ") == [
        f"leg_length[{i}]: leg {i} is past a stop, got {length!r} m, {expected}"
        for i, length in enumerate(lengths, start=1)
    ]


def test_a_start_pose_that_is_no_number_is_refused():
    with pytest.raises(ModelError, match=r"leg_length\[1\]: leg 1 is past a stop, got nan m"):
        started(s_act=math.nan)


def test_an_infinite_start_angle_is_refused():
    with pytest.raises(ModelError, match=r"motion_simulator at t=0.0 s: the equations have no result, math"):
        started(roll_act=math.inf)


def test_a_command_past_a_stop_names_the_leg_and_its_length():
    instance = at_rest(dead_time=0.0)
    instance["s_cmd"] = 0.5

    with pytest.raises(
        ModelError, match=r"leg_reference\[1\]: leg 1 is commanded past a stop, got 1\.96\d+ m"
    ):
        instance.step(0.0, SAMPLE)


def test_a_leg_pushed_past_its_stop_ends_the_run():
    instance = at_rest()
    instance["f_contact"] = 1e6

    with pytest.raises(ModelError, match=r"leg_length\[\d\]: leg \d is past a stop, got"):
        run(instance, 1000)


@pytest.mark.parametrize("name", POSITIVE)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_zero_negative_and_no_number_are_refused(name, value):
    with pytest.raises(ModelError, match=rf"^{name}: value not allowed, got {value}"):
        at_rest(**{name: value})


@pytest.mark.parametrize("name", MODEL.parameters.names)
def test_an_infinite_parameter_is_refused(name):
    with pytest.raises(ModelError, match=f"^{name}: "):
        at_rest(**{name: math.inf})


@pytest.mark.parametrize("name", ["wrench[2]", "pose_cmd[4]", "s_cmd", "f_contact"])
def test_an_input_that_is_no_number_is_refused(name):
    instance = at_rest()
    instance[name] = math.nan

    with pytest.raises(ModelError, match=rf"^{name.partition('[')[0]}.*: value not allowed, got nan"):
        instance.step(0.0, SAMPLE)


def test_a_huge_load_is_an_error_without_a_crash():
    instance = at_rest()
    instance["f_contact"] = 1e300

    with pytest.raises(ModelError):
        instance.step(0.0, SAMPLE)
