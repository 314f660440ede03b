"""Events of a system happen within its FMU as in `dockloop run`, whatever they do."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from master.fuse.runs import FusedRuns, fused_form
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate
from tests.master.fuse.fused_run import Host, assert_same_bits, expected_rows, exported, prepared
from tests.master.fuse.systems import EVENTS, MEMBERS, with_events

pytestmark = pytest.mark.slow

ORDERS = {
    "in a sequence": None,
    "side by side": [[*MEMBERS, "free"]],
    "iterated": [{"iterate": MEMBERS, "tolerance": 1e-9, "maximum": 80}, "free"],
}
ALL = [event for events in EVENTS.values() for event in events]


def rows_without(experiment) -> np.ndarray:
    return simulate(experiment.system, experiment.schedule, experiment.grid).result.values


@pytest.mark.parametrize("events", EVENTS)
def test_events_of_each_kind_have_the_bits_of_run(events, tmp_path):
    experiment = prepared(tmp_path, with_events(EVENTS[events]))

    assert not np.array_equal(expected_rows(experiment)[1], rows_without(experiment))
    assert_same_bits(experiment, exported(experiment, tmp_path))


@pytest.mark.long
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_all_of_them_at_once_have_the_bits_of_run_whatever_the_order(order, version, tmp_path):
    data = with_events(ALL, ORDERS[order], wires={} if order == "iterated" else None)
    experiment = prepared(tmp_path, data)
    fmu = exported(experiment, tmp_path, version)

    assert validate_fmu(str(fmu)) == []
    assert_same_bits(experiment, fmu)


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def fused(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("events")
    experiment = prepared(folder, with_events(ALL))
    return experiment, exported(experiment, folder, request.param)


def test_a_saved_state_holds_what_has_happened_and_a_reset_forgets_it(fused):
    experiment, fmu = fused
    names, values = expected_rows(experiment)
    h = experiment.grid.step_size
    host = Host(fmu).start()
    save, restore = (
        (host.fmu.getFMUstate, host.fmu.setFMUstate)
        if host.is_2
        else (host.fmu.getFMUState, host.fmu.setFMUState)
    )
    host.rows(names, 47, h)
    state = save()
    first = host.rows(names, 100, h, 47 * h)
    restore(state)
    again = host.rows(names, 100, h, 47 * h)
    host.fmu.reset()
    anew = host.start().rows(names, experiment.grid.n_ticks, h)
    pack, unpack = (
        (host.fmu.serializeFMUstate, host.fmu.deSerializeFMUstate)
        if host.is_2
        else (host.fmu.serializeFMUState, host.fmu.deserializeFMUState)
    )
    restore(unpack(pack(state)))
    from_bytes = host.rows(names, 100, h, 47 * h)
    host.end()

    assert first.tobytes() == values[47:148].tobytes()
    assert again.tobytes() == first.tobytes()
    assert from_bytes.tobytes() == first.tobytes()
    assert anew.tobytes() == values.tobytes()


def test_steps_of_several_ticks_meet_each_event_at_its_tick(fused):
    experiment, fmu = fused
    names, values = expected_rows(experiment)
    host = Host(fmu).start()
    rows = host.rows(names, 40, 5 * experiment.grid.step_size)
    host.end()

    assert rows.tobytes() == values[:201:5].tobytes()


def test_an_event_holds_over_what_a_host_sets_which_holds_again_after_it(tmp_path):
    experiment = prepared(tmp_path, with_events([{"at": 0.002, "set": {"free.f": 30.0}, "for": 0.002}]))
    host = Host(exported(experiment, tmp_path)).start()
    host.set("free.f", 6.0)
    speeds = [row[0] for row in host.rows(["free.v_des"], 6, 1e-3)]
    shown = host.get("free.f")
    host.end()

    assert np.diff(speeds) / 1e-3 == pytest.approx([2.0, 2.0, 10.0, 10.0, 2.0, 2.0])
    assert shown == [6.0]


def test_an_event_that_an_fmu_refuses_ends_the_step_with_its_words(tmp_path):
    events = [{"at": 0.002, "set": {"contact.k_p": 0.0}}]
    experiment = prepared(tmp_path, with_events(events))
    options = RunOptions(scenario=experiment.scenario)
    run = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)
    host = Host(exported(experiment, tmp_path, "3.0")).start()
    if run.error is None:
        host.rows(["free.v_des"], 6, 1e-3)
    else:
        with pytest.raises(FMICallException):
            host.rows(["free.v_des"], 6, 1e-3)
        assert "contact: k_p" in host.messages[-1]
    host.end()


def test_a_start_at_another_time_is_refused(fused):
    host = Host(fused[1])
    with pytest.raises(FMICallException):
        host.start(1.0)
    if not host.is_2:
        assert host.messages[-1] == ("events: at times of the system, got a start at 1.0 s, expected 0 s")
    host.end()


def test_runs_of_a_campaign_are_fused_with_their_events(tmp_path):
    experiment = prepared(tmp_path, with_events(ALL))
    runs = FusedRuns(fused_form(experiment), experiment)
    found = runs.run(experiment)

    assert found.result.values.tobytes() == expected_rows(experiment)[1].tobytes()
    runs.close()
