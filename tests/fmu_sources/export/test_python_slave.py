"""The shell of the Python flavour, without a host."""

from __future__ import annotations

import pytest
from pythonfmu.enums import Fmi2Status

from fmu_sources.composed.registry import load
from fmu_sources.export.python_slave import ModelSlave
from fmu_sources.framework.instance import ModelError


class Slave(ModelSlave):
    model = load("spacecraft")


def reference(name):
    return next(i for i, v in enumerate(Slave.model.all_variables) if v.name == name)


@pytest.fixture
def slave():
    made = Slave(instance_name="one", resources=".")
    made.setup_experiment(2.0)
    made.enter_initialization_mode()
    return made


def said(slave):
    return [(message.status, message.msg) for message in slave.log_queue]


def test_values_set_while_initialising_are_in_what_is_read_then(slave):
    slave.set_real([reference("s_des")], [0.25])

    assert slave.get_real([reference("s_des")]) == [0.25]


def test_a_step_moves_the_mass(slave):
    slave.set_real([reference("m_s"), reference("f")], [2.0, 4.0])
    slave.exit_initialization_mode()

    assert slave.do_step(2.0, 1e-3)
    assert slave.get_real([reference("v_des"), reference("s_des")]) == pytest.approx([2e-3, 2e-6])


def test_a_refused_step_is_an_error_in_the_log_and_changes_nothing(slave):
    slave.exit_initialization_mode()

    assert not slave.do_step(2.0, 1.5e-3)
    assert said(slave)[-1] == (
        Fmi2Status.error,
        "communication step: not a multiple of sample_time, got 0.0015 s, expected a multiple of 0.001 s",
    )
    assert slave.do_step(2.0, 1e-3)


def test_a_bad_parameter_is_refused_at_initialisation_and_before_a_step(slave):
    slave.set_real([reference("m_s")], [-1.0])
    with pytest.raises(ModelError, match=r"m_s: value not allowed, got -1\.0 kg, expected above 0\.0"):
        slave.exit_initialization_mode()

    slave.set_real([reference("m_s")], [1.0])
    slave.exit_initialization_mode()
    slave.set_real([reference("m_s")], [0.0])
    assert not slave.do_step(2.0, 1e-3)
    assert "m_s: value not allowed, got 0.0 kg" in said(slave)[-1][1]


def test_a_saved_state_brings_a_run_back(slave):
    slave.set_real([reference("f")], [10.0])
    slave.exit_initialization_mode()
    slave.do_step(2.0, 1e-3)
    saved, before = slave._get_fmu_state(), slave.get_real([reference("s_des")])
    slave.do_step(2.001, 1e-3)
    later = slave.get_real([reference("s_des")])
    slave._set_fmu_state(saved)

    assert slave.get_real([reference("s_des")]) == before != later
    slave.do_step(2.001, 1e-3)
    assert slave.get_real([reference("s_des")]) == later
