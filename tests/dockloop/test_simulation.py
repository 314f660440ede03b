"""Step by step: reading, setting, saving and going back."""

from __future__ import annotations

import pytest

import dockloop as dl
from tests.dockloop.conftest import integrator, semi_implicit


def test_single_steps_are_the_run(sprung):
    with sprung.open() as sim:
        found = [sim["mass.s_des"]]
        while not sim.is_done:
            sim.step()
            found.append(sim["mass.s_des"])
        rows = sim.result()["mass.s_des"].tolist()

    assert found == rows == semi_implicit(500)
    assert sim.status == "completed"


def test_a_shipped_system_steps_as_it_runs():
    system = dl.load("low_frequency")
    run = system.run(stop_time=0.3)
    with system.open(stop_time=0.3) as sim:
        sim.step(7)
        sim.step(300)
        found = sim.result()

    assert found.signals == run.signals
    assert all((found[name] == run[name]).all() for name in run.signals)


def test_a_restored_state_goes_on_with_the_same_bits():
    with dl.load("low_frequency").open(stop_time=1.0) as sim:
        sim.step(200)
        state = sim.save()
        sim.step(500)
        first = sim.result()
        sim.restore(state)
        assert (sim.t, len(sim.result())) == (0.2, 201)
        sim.set("force_sensor.sigma", 0.5)
        sim.step(500)
        other = sim.result()
        sim.restore(state)
        sim.set("force_sensor.sigma", 0.0316)
        sim.step(500)
        again = sim.result()

    assert all((first[name] == again[name]).all() for name in first.signals)
    assert (first["spacecraft.s_des"] != other["spacecraft.s_des"]).any()


def test_the_state_of_a_block_is_saved_too_and_each_run_begins_anew():
    system = dl.load({"name": "i", "stop_time": 1.0, "step_size": 0.25, "fmus": {"i": integrator()}})
    assert system.run(set={"i.u": 2.0})["i.x"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    with system.open(set={"i.u": 2.0}) as sim:
        sim.step(2)
        state = sim.save()
        sim.step()
        sim.restore(state)
        sim.set("i.u", 4.0)
        sim.step()

        assert sim["i.x"] == 2.0


def test_what_is_set_acts_from_the_next_step_on(sprung):
    with sprung.open() as sim:
        sim.step()
        sim.set("spring.k", 0.0)
        v = sim["mass.v_des"]
        sim.step(3)

        assert sim["mass.v_des"] == v
        assert sim["spring.k"] == 0.0


def test_two_simulations_are_open_at_a_time(sprung):
    with sprung.open() as one, sprung.open(set={"spring.k": 50.0}) as two:
        for _ in range(20):
            one.step()
            two.step()

        assert one["mass.s_des"] == semi_implicit(20)[-1]
        assert two["mass.s_des"] == semi_implicit(20, k=50.0)[-1]
        one.close()
        two.step()
        assert two["mass.s_des"] == semi_implicit(21, k=50.0)[-1]


def test_a_result_stays_when_the_simulation_goes_back(sprung):
    with sprung.open() as sim:
        state = sim.save()
        sim.step(5)
        run = sim.result()
        sim.restore(state)
        sim.set("spring.k", 0.0)
        sim.step(5)

    assert run["mass.s_des"].tolist() == semi_implicit(5)


def test_a_diverged_simulation_can_go_back():
    with dl.load("low_frequency").open("none", set={"spacecraft.m_s": 500}) as sim:
        sim.step(1000)
        state = sim.save()
        sim.step(9000)
        assert sim.status == "diverged"
        with pytest.raises(dl.ConfigError, match="the run diverged, expected a restored state"):
            sim.step()
        sim.restore(state)
        assert (sim.status, sim.t) == ("running", 1.0)
        sim.step()


@pytest.mark.parametrize(
    ("signal", "value", "message"),
    [
        ("mass.sample_time", 0.1, "is fixed during a run"),
        ("mass.f", 1.0, "a connection to mass.f"),
        ("mass.s_des", 1.0, "is of kind output"),
        ("mass.m_s", -1.0, "expected"),
        ("mas.m_s", 1.0, "no such FMU, got 'mas', expected 'mass'"),
        ("spring.k", "stiff", "expected a number"),
    ],
)
def test_what_cannot_be_set_now_is_refused(sprung, signal, value, message):
    with sprung.open() as sim:
        sim.step()
        with pytest.raises(dl.MasterError, match=message):
            sim.set(signal, value)


def test_what_is_closed_or_done_says_so(sprung):
    with sprung.open(stop_time=0.002) as sim:
        sim.step(5)
        with pytest.raises(dl.ConfigError, match="at the stop time"):
            sim.step()
        with pytest.raises(dl.ConfigError, match="a positive integer"):
            sim.step(0)
    with pytest.raises(dl.ConfigError, match="closed"):
        sim["mass.s_des"]


def test_a_state_of_another_simulation_is_refused(sprung):
    with sprung.open() as one, sprung.open() as two, pytest.raises(dl.ConfigError, match="another run"):
        two.restore(one.save())
