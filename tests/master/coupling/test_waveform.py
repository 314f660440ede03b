"""Waveform relaxation: converged it is the iteration of each tick, over values from outside of that tick."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from master.errors import ConfigError
from master.system.config import Config, LoadedConfig
from master.system.inputs import Feed, MeasuredInputs
from master.system.scenario import make_scenario
from tests.linear_blocks import Linear
from tests.stubs import Block, bench, clock, gain, integrator, variables, wire

STIFF, SOFT, DAMP, END = 40.0, 25.0, 0.8, 1.0
WHOLE = np.array(
    [
        [0.0, 1.0, 0.0, 0.0],
        [-STIFF - SOFT, -DAMP, SOFT, DAMP],
        [0.0, 0.0, 0.0, 1.0],
        [SOFT, DAMP, -STIFF - SOFT, -DAMP],
    ]
)


def waveform(members, window, **more):
    return {"waveform": members, "window": window, "tolerance": 1e-13, "maximum": 200, **more}


def two_masses(group, step):
    """Each exact for an input that is linear in a step, joined by a spring and a damper."""
    first = Linear([[0, 1], [-STIFF, 0]], [[0], [-1]], ("x", "v"), ("f_in",))
    own, force = [[0, 1], [-STIFF - SOFT, -DAMP]], {"f": ([-SOFT, -DAMP], [SOFT, DAMP])}
    second = Linear(own, [[0, 0], [SOFT, DAMP]], ("x", "v"), ("x_in", "v_in"), force)
    wires = [wire("b.f", "a.f_in"), wire("a.x", "b.x_in"), wire("a.v", "b.v_in")]
    blocks = {"a": first.block(), "b": second.block()}
    return bench(blocks, wires, [group], step_size=step, start={"a": {"x": 1.0}})


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("sweep", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("window", [1, 4, 10])
def test_at_the_end_of_each_window_it_has_the_values_of_an_iteration_of_each_tick(window, sweep, compiled):
    iterated = two_masses({"iterate": ["a", "b"], "tolerance": 1e-14, "maximum": 200}, 0.01)
    expected = iterated.run(40).result
    outcome = two_masses(waveform(["a", "b"], window, sweep=sweep), 0.01).run(40, compiled=compiled)

    assert outcome.status == "completed", outcome.error
    for name in ("a.x", "b.x", "b.f"):
        np.testing.assert_allclose(
            outcome.result[name][::window], expected[name][::window], rtol=0.0, atol=1e-10
        )


def error(window, step):
    n = round(END / step)
    result = two_masses(waveform(["a", "b"], window), step).run(n).result
    exact = np.array([expm(WHOLE * step * k) @ [1.0, 0.0, 0.0, 0.0] for k in range(0, n + 1, window)])
    return np.abs(np.column_stack([result["a.x"], result["b.x"]])[::window] - exact[:, [0, 2]]).max()


def test_its_error_against_the_exact_solution_falls_with_the_square_of_the_step():
    order = np.log2(error(5, 0.01) / error(5, 0.005))

    assert order == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(
    ("order", "expected"),
    [
        (["clock", waveform(["sum"], 4)], [0, 0, 0, 0, 10, 10, 10, 10, 36, 36]),
        ([waveform(["sum"], 4), "clock"], [0, 0, 0, 0, 6, 6, 6, 6, 28, 28]),
    ],
)
def test_each_step_of_a_window_takes_the_value_of_its_own_tick_from_outside(order, expected):
    """The sum of the clock's rows 1 to 4, or 0 to 3, after the window, and nothing before its end."""
    made = bench({"clock": clock(), "sum": integrator()}, [wire("clock.t", "sum.u")], order)

    assert made.run(9, compiled=True).result["sum.x"].tolist() == expected


@pytest.mark.parametrize("compiled", [False, True])
def test_each_step_of_a_window_takes_the_measured_value_of_its_own_tick(compiled):
    """The sum of the recording's rows 1 to 4 after the first window, and 1 to 8 after the second."""
    made = bench({"sum": integrator()}, [], [waveform(["sum"], 4)])
    feed = Feed("recording.u", "sum.u")
    inputs = MeasuredInputs((feed,), np.arange(10.0)[:, None] ** 2)
    result = made.run(9, inputs=inputs, compiled=compiled).result

    assert result["sum.x"].tolist() == [0, 0, 0, 0, 30, 30, 30, 30, 204, 204]


def test_measured_values_reach_every_pass_of_a_window_over_a_loop():
    """The loop p = -q/2 + w, q = p with w the measured t: the solution is t/1.5 at each window's end."""
    blocks = {"p": affine(-0.5, []), "q": affine(1.0, [])}
    made = bench(blocks, [wire("p.y", "q.u"), wire("q.y", "p.u")], [waveform(["p", "q"], 3)])
    inputs = MeasuredInputs((Feed("recording.w", "p.w"),), np.arange(10.0)[:, None])
    result = made.run(9, inputs=inputs).result

    np.testing.assert_allclose(result["q.y"][3::3], np.array([3.0, 6.0, 9.0]) / 1.5, rtol=0.0, atol=1e-12)


def test_the_ledger_counts_the_window_for_what_leaves_it_only():
    blocks = {"clock": clock(), "a": integrator(), "b": gain(), "out": gain()}
    wires = [wire("clock.t", "a.u"), wire("a.x", "b.u"), wire("b.y", "out.u")]
    ledger = bench(blocks, wires, ["clock", waveform(["a", "b"], 4), "out"]).ledger

    assert [(e.least, e.most) for e in ledger.entries] == [(0, 0), (0, 0), (0, 3)]


def test_an_event_on_a_connection_from_outside_acts_in_its_own_tick():
    """From t = 2 on 10 more: 1 + 2 + (3 + 10) + (4 + 10)."""
    made = bench(
        {"clock": clock(), "sum": integrator()},
        [wire("clock.t", "sum.u")],
        ["clock", waveform(["sum"], 4)],
    )
    config = made.loaded.config.model_dump(by_alias=True)
    config |= {"events": [{"at": 2.0, "offset": {"sum.u": 10.0}}], "stop_time": 9.0}
    loaded = LoadedConfig(config=Config.model_validate(config), document=made.loaded.document)

    result = made.run(4, scenario=make_scenario(loaded, made.system)).result

    assert result["sum.x"][4] == 30.0


def test_an_event_on_a_connection_within_the_group_is_refused():
    made = bench({"a": clock(), "b": gain()}, [wire("a.t", "b.u")], [{"waveform": ["a", "b"], "window": 3}])
    config = made.loaded.config.model_dump(by_alias=True)
    config |= {"events": [{"at": 2.0, "freeze": "b.u"}], "stop_time": 9.0}
    loaded = LoadedConfig(config=Config.model_validate(config), document=made.loaded.document)

    with pytest.raises(ConfigError, match=r"events: b\.u is closed over a window of 3 ticks"):
        made.run(4, scenario=make_scenario(loaded, made.system))


def affine(factor, calls):
    """Output y = factor*u + w in a step, 0 at the start; its steps are counted."""

    def law(t, h, v):
        calls.append(t) if h else None
        return {"y": factor * v["u"] + v["w"] if h else 0.0}

    return Block(law, variables(("u", "input"), ("w", "input"), ("y", "output")))


def sweeps(sweep):
    """Sweeps over a window of 2 ticks of p = -q/2 + t, q = p, to 1e-6; the solution is t/1.5."""
    calls = []
    blocks = {"clock": clock(), "p": affine(-0.5, calls), "q": affine(1.0, [])}
    wires = [wire("p.y", "q.u"), wire("q.y", "p.u"), wire("clock.t", "p.w")]
    group = {"waveform": ["p", "q"], "window": 2, "sweep": sweep, "tolerance": 1e-6, "maximum": 100}
    result = bench(blocks, wires, ["clock", group]).run(2).result
    assert result["q.y"][2] == pytest.approx(2.0 / 1.5, abs=2e-6)
    return len(calls) // 2


def test_gauss_seidel_halves_the_error_in_each_sweep_and_jacobi_in_each_second_one():
    """Errors of 2/1.5 * 2^-k: 2 * 2^-k <= 1e-6 after 21 sweeps, and one that finds nothing to change."""
    assert sweeps("gauss_seidel") in (21, 22)
    assert sweeps("jacobi") in (42, 43, 44)


@pytest.mark.parametrize("compiled", [False, True])
def test_waveforms_that_do_not_agree_end_the_run_with_the_connection(compiled):
    calls = []
    blocks = {"clock": clock(), "p": affine(-2.0, calls), "q": affine(1.0, [])}
    wires = [wire("p.y", "q.u"), wire("q.y", "p.u"), wire("clock.t", "p.w")]
    group = {"waveform": ["p", "q"], "window": 2, "maximum": 7}
    outcome = bench(blocks, wires, ["clock", group]).run(4, compiled=compiled)

    assert (outcome.status, outcome.steps, len(calls)) == ("failed", 1, 14)
    assert "the iteration over q.y -> p.u does not converge" in str(outcome.error)


@pytest.mark.parametrize(
    ("more", "fault"),
    [
        ({"every": {"b": 2}}, "b is in a waveform group, got every 2 ticks, expected every: 1"),
        ({"extrapolation": 1}, "an iterated connection is not extrapolated, got a.y -> b.u"),
        ({"state": False}, "a cannot be iterated, got an FMU that does not save its state"),
    ],
)
def test_what_a_window_cannot_do_is_refused(more, fault, monkeypatch):
    block = gain()
    if not more.get("state", True):
        description = block.description
        monkeypatch.setattr(
            Block, "description", lambda *given: replace(description("stub"), can_get_and_set_state=False)
        )
    wires = [wire("a.y", "b.u", extrapolation=more.get("extrapolation", 0))]
    with pytest.raises(ConfigError) as caught:
        bench({"a": block, "b": gain()}, wires, [waveform(["a", "b"], 2)], every=more.get("every"))

    assert any(fault in problem for problem in caught.value.problems)
