"""What a host may ask of a fused FMU: values, states, several instances, resets, errors with their words."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from master.fmi.description_reader import read_description
from tests.master.fuse.fused_run import Host, expected_rows, prepared
from tests.master.fuse.systems import with_conversions

H = 1e-3
SHOWN = ["spacecraft.s_des", "other.v_des", "free.s_des", "force_sensor.f_mea"]

pytestmark = pytest.mark.slow


@pytest.fixture
def host(converted):
    host = Host(converted.fmu)
    yield host
    host.end()


def test_it_is_valid(converted):
    assert validate_fmu(str(converted.fmu)) == []


def test_its_variables_have_the_units_bounds_and_start_values_of_the_system(converted):
    found = read_description(converted.fmu).by_name
    system = converted.experiment.system

    for name, instance in system.instances.items():
        connected = {wire.target.variable.name for wire in system.wires_into(name)}
        for v in instance.description.variables:
            mine = found[f"{name}.{v.name}"]
            assert (mine.kind, mine.unit_name, mine.items) == (v.kind, v.unit_name, v.items)
            if v.name in connected:
                assert (mine.causality, mine.start) == ("local", None)
                continue
            assert (mine.causality, mine.minimum, mine.maximum) == (v.causality, v.minimum, v.maximum)
            if v.is_settable:
                assert mine.start_value == instance.value_of(v.name)
    assert found["free.f"].causality == "input"
    assert set(found) - {"time"} == {
        f"{name}.{v.name}" for name, i in system.instances.items() for v in i.description.variables
    } - {f"{name}.time" for name in system.instances}


def test_parameters_and_start_values_set_by_a_host_are_those_of_set(converted, host, tmp_path):
    given = {"spacecraft.m_s": 300.0, "other.s_des": 0.25, "free.f": -1.5}
    assignments = tuple(f"{name}={value}" for name, value in given.items())
    experiment = prepared(tmp_path, with_conversions(), assignments=assignments)
    names, values = expected_rows(experiment)

    for name, value in given.items():
        host.set(name, value)
    rows = host.start().rows(names, experiment.grid.n_ticks, H)

    assert rows.tobytes() == values.tobytes()


def test_an_input_and_a_tunable_parameter_act_from_the_next_step_on(host):
    host.start()
    host.fmu.doStep(0.0, H)
    before = host.get("free.v_des")[0]
    host.set("free.f", 30.0)
    host.set("free.m_s", 10.0)
    host.fmu.doStep(H, H)

    assert host.get("free.v_des")[0] == before + H * 30.0 / 10.0


def test_steps_of_several_ticks_reach_the_values_of_single_ones(converted):
    single, several = Host(converted.fmu).start(), Host(converted.fmu).start()
    rows = single.rows(SHOWN, 12, H)
    again = several.rows(SHOWN, 4, 3 * H)
    single.end()
    several.end()

    assert again.tobytes() == rows[::3].tobytes()


def test_instances_share_nothing_and_a_reset_one_begins_again(converted):
    first, second = Host(converted.fmu, "first").start(), Host(converted.fmu, "second")
    second.set("spacecraft.m_s", 100.0)
    second.start()
    mixed = [first.get(*SHOWN)]
    for k in range(20):
        first.fmu.doStep(k * H, H)
        second.fmu.doStep(k * H, H)
        mixed.append(first.get(*SHOWN))
    first.fmu.reset()
    alone = first.start().rows(SHOWN, 20, H)
    first.end()
    second.end()

    assert alone.tobytes() == np.array(mixed).tobytes()


def test_a_saved_state_brings_back_every_later_row_also_as_bytes(host):
    fmu = host.fmu
    save, restore = (fmu.getFMUstate, fmu.setFMUstate) if host.is_2 else (fmu.getFMUState, fmu.setFMUState)
    pack, unpack = (
        (fmu.serializeFMUstate, fmu.deSerializeFMUstate)
        if host.is_2
        else (fmu.serializeFMUState, fmu.deserializeFMUState)
    )
    host.start().rows(SHOWN, 15, H)
    state = save()
    rows = host.rows(SHOWN, 15, H, 15 * H)
    restore(state)
    again = host.rows(SHOWN, 15, H, 15 * H)
    restore(unpack(pack(state)))
    from_bytes = host.rows(SHOWN, 15, H, 15 * H)

    assert again.tobytes() == rows.tobytes()
    assert from_bytes.tobytes() == rows.tobytes()


def test_outputs_are_readable_in_initialisation_mode_and_follow_what_is_set(host):
    host.enter()
    before = host.get("motion_simulator.s_act")
    host.set("motion_simulator.s_act", 0.5)

    assert before == [-0.01]
    assert host.get("motion_simulator.s_act") == [0.5]
    assert host.get("contact.s_act") == [0.5 * 1.25]


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("spacecraft.m_s", -1.0, "spacecraft.m_s: value not allowed, got -1.0 kg, expected above 0.0"),
        ("free.f", float("nan"), "free.f: value not allowed, got nan N, expected a finite number"),
        ("other.integrator", 9, "other.integrator: value not allowed, got 9, expected one of 1 (semi"),
    ],
)
def test_what_an_fmu_refuses_is_refused_with_its_words(host, name, value, said):
    host.set(name, value)
    with pytest.raises(FMICallException):
        host.start()
    if not host.is_2:
        assert host.messages[-1].startswith(said)


def test_an_fmu_that_fails_in_a_step_is_named(host):
    host.start()
    host.set("free.m_s", 1e-300)
    host.set("free.f", 1e300)

    with pytest.raises(FMICallException):
        host.fmu.doStep(0.0, H)
    if not host.is_2:
        assert host.messages[-1].startswith("free: s_des: value not finite at t=0.001 s, got inf m")


@pytest.mark.parametrize(("t", "h"), [(0.0, 0.5e-3), (0.0, 1.5e-3), (0.0, 0.0), (0.0, -1e-3), (0.5, 1e-3)])
def test_a_step_that_is_not_of_the_grid_is_refused_and_changes_nothing(host, t, h):
    host.start()
    before = host.get(*SHOWN)
    with pytest.raises(FMICallException):
        host.fmu.doStep(t, h)
    assert host.get(*SHOWN) == before
    host.fmu.doStep(0.0, H)


def test_a_connected_input_shows_what_arrives_and_cannot_be_set(host):
    host.start().rows(SHOWN, 3, H)
    sent, arrived = host.get("motion_simulator.s_act", "contact.s_act")

    assert arrived == sent * 1.25
    with pytest.raises(FMICallException):
        host.set("contact.s_act", 1.0)
