import logging
import signal
import threading

import numpy as np
import pytest

from master.errors import FmuError
from master.process import signals
from master.stepping.simulate import simulate
from master.system.grid import Grid
from tests.stubs import (
    ERROR,
    FATAL,
    Block,
    bench,
    calling,
    clock,
    failing,
    gain,
    growing,
    integrator,
    typed,
    variables,
    wire,
)


def test_row_0_holds_the_initial_values():
    made = bench({"a": integrator(), "g": gain(3.0)}, [wire("a.x", "g.u")], start={"a": {"x": 2.0}})
    result = made.run(0).result

    assert result.time.tolist() == [0.0]
    assert result["a.x"].tolist() == [2.0]
    assert result["g.y"].tolist() == [6.0]


@pytest.mark.parametrize("order", [["a", "b", "c", "d"], ["d", "c", "b", "a"], [["c", "a", "d", "b"]]])
def test_initial_values_run_through_a_chain_in_every_order(order):
    blocks = {"a": integrator(), "b": gain(2.0), "c": gain(3.0), "d": gain(5.0)}
    wires = [wire("a.x", "b.u"), wire("b.y", "c.u"), wire("c.y", "d.u")]
    result = bench(blocks, wires, order, start={"a": {"x": 7.0}}).run(0).result

    assert result["d.y"].tolist() == [210.0]


def test_a_loop_that_a_state_breaks_settles_at_the_start():
    blocks = {"mass": integrator(), "spring": gain(-4.0)}
    wires = [wire("mass.x", "spring.u"), wire("spring.y", "mass.u")]
    result = bench(blocks, wires, [["mass", "spring"]], start={"mass": {"x": 0.5}}).run(1).result

    assert result["spring.y"].tolist() == [-2.0, -2.0]
    assert result["mass.x"].tolist() == [0.5, -1.5]


def test_an_algebraic_loop_at_the_start_is_named():
    blocks = {"p": gain(2.0), "q": Block(lambda t, h, v: {"y": v["u"] + 1.0}, gain().variables)}
    made = bench(blocks, [wire("p.y", "q.u"), wire("q.y", "p.u")], ["p", "q"])

    with pytest.raises(FmuError, match="initial values do not settle") as caught:
        made.run(1)
    assert "p.y -> q.u" in str(caught.value)
    assert "expected no algebraic loop at the start" in str(caught.value)


@pytest.mark.parametrize("order", [["p", "q"], ["q", "p"]])
def test_an_initial_value_runs_through_two_slaves_many_times(order):
    """Five wires between two: twice as many passes against the order as there are slaves."""
    names = range(6)
    ports = variables(*[(f"u{i}", "input") for i in names], *[(f"y{i}", "output") for i in names])
    block = Block(lambda t, h, v: {f"y{i}": v[f"u{i}"] + 1.0 for i in names}, ports)
    wires = [wire(f"{'pq'[i % 2]}.y{i}", f"{'qp'[i % 2]}.u{i + 1}") for i in range(5)]
    result = bench({"p": block, "q": block}, wires, order).run(0).result

    assert result["q.y5"].tolist() == [6.0]


@pytest.mark.parametrize("order", [["p", "q"], ["q", "p"]])
def test_an_iterated_group_solves_an_algebraic_loop_at_the_start(order):
    """The loop p = -q/2 + 1, q = p is solved by 2/3."""
    blocks = {
        "p": Block(lambda t, h, v: {"y": 1.0 - 0.5 * v["u"]}, gain().variables),
        "q": gain(),
    }
    group = {"iterate": order, "tolerance": 1e-12, "maximum": 100}
    made = bench(blocks, [wire("p.y", "q.u"), wire("q.y", "p.u")], [group])

    assert made.run(1).result["q.y"] == pytest.approx([2 / 3, 2 / 3], abs=1e-11)


def test_a_real_settles_in_an_integer_and_a_boolean():
    wires = [wire("clock.t", "typed.i"), wire("clock.t", "typed.b")]
    result = bench({"clock": clock(), "typed": typed()}, wires).run(0, t0=0.75).result

    assert (result["typed.i_out"][0], result["typed.b_out"][0]) == (1.0, 1.0)


def test_a_start_value_reaches_the_slave():
    made = bench({"a": integrator()}, start={"a": {"x": -1.0, "u": 0.5}}, step_size=2.0)

    assert made.run(3).result["a.x"].tolist() == [-1.0, 0.0, 1.0, 2.0]


@pytest.mark.parametrize("compiled", [False, True])
def test_divergence_stops_the_run_and_keeps_the_rows(compiled):
    outcome = bench({"a": growing(2.0)}).run(100, limits={"a.y": 10.0}, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("diverged", 4)
    assert outcome.result["a.y"].tolist() == [1.0, 2.0, 4.0, 8.0, 16.0]
    assert outcome.cause == "a.y: got 16 m, expected a magnitude of at most 10 m"


def test_the_row_in_which_a_run_diverges_is_whole():
    outcome = bench({"a": growing(2.0), "b": clock()}).run(100, limits={"a.y": 10.0})

    assert outcome.result["b.t"].tolist() == outcome.result.time.tolist()


def broken(value):
    """Output y is the time until 2 s, and then a value that is not finite."""
    return Block(lambda t, h, v: {"y": value if t >= 2.0 else t}, variables(("y", "output")))


NOT_FINITE = [
    (float("nan"), "a.y is not a number, got nan, expected a finite value"),
    (float("inf"), "a.y is infinite, got inf, expected a finite value"),
    (-float("inf"), "a.y is infinite, got -inf, expected a finite value"),
]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(("value", "cause"), NOT_FINITE)
def test_a_value_that_is_not_finite_and_goes_to_an_fmu_is_divergence(value, cause, compiled):
    outcome = bench({"a": broken(value), "b": gain()}, [wire("a.y", "b.u")]).run(9, compiled=compiled)

    assert (outcome.status, outcome.steps, outcome.cause) == ("diverged", 3, cause)


@pytest.mark.parametrize("used", [{"compared": ["a.y"]}, {"limits": {"a.y": 1e300}}])
@pytest.mark.parametrize(("value", "cause"), NOT_FINITE)
def test_a_value_that_is_not_finite_and_compared_or_limited_is_divergence(value, cause, used):
    outcome = bench({"a": broken(value)}).run(9, **used)

    assert (outcome.status, outcome.steps, outcome.cause) == ("diverged", 3, cause)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(("value", "_"), NOT_FINITE)
def test_a_value_that_is_not_finite_and_that_nobody_uses_is_a_warning(value, _, compiled):
    outcome = bench({"a": broken(value), "b": clock()}).run(9, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("completed", 9)
    assert outcome.warnings == ["a.y is not finite from t=3 s on; nothing uses it"]


def test_a_value_at_its_limit_has_not_diverged():
    outcome = bench({"a": growing(2.0)}).run(3, limits={"a.y": 8.0})

    assert outcome.status == "completed"


def test_ctrl_c_ends_the_run_between_two_chunks_and_keeps_the_rows():
    made = bench({"a": calling(lambda t: t == 10.0 and signal.raise_signal(signal.SIGINT))})
    outcome = made.run(100_000)

    assert outcome.status == "interrupted"
    assert 11 <= outcome.steps < 100_000
    assert outcome.result["a.t"].tolist() == list(range(outcome.steps + 1))


def test_ctrl_c_ends_a_command_that_works_with_runs_and_gives_it_no_short_one(monkeypatch):
    monkeypatch.setattr(signals, "_unheeded", [])
    before = {number: signal.getsignal(number) for number in signals.SIGNALS}
    made = bench({"a": calling(lambda t: t == 10.0 and signal.raise_signal(signal.SIGINT))})
    try:
        signals.end_at_once()
        with pytest.raises(SystemExit, match="130"):
            made.run(100_000)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_ctrl_c_means_afterwards_what_it_meant_before():
    before = signal.getsignal(signal.SIGINT)
    bench({"a": clock()}).run(1)

    assert signal.getsignal(signal.SIGINT) is before


def test_a_run_outside_the_main_thread_completes():
    outcomes = []
    thread = threading.Thread(target=lambda: outcomes.append(bench({"a": clock()}).run(5)))
    thread.start()
    thread.join()

    assert outcomes[0].status == "completed"


def test_progress_counts_every_tick_once():
    seen = []
    bench({"a": clock()}).run(1000, progress=seen.append)

    assert sum(seen) == 1000
    assert len(seen) > 1


def test_chunks_leave_no_trace_in_delays_and_rates():
    wires = [wire("a.t", "b.u", delay=7)]
    made = bench({"a": clock(), "b": gain()}, wires, ["a", "b"], every={"b": 5})
    result = made.run(500).result

    k = np.arange(501)
    assert result["b.y"].tolist() == np.maximum(0, k // 5 * 5 - 7).tolist()


def test_every_slave_is_closed_after_a_run():
    made = bench({"a": clock(), "b": clock()})
    made.run(3)

    for slave in made.slaves.values():
        assert slave.events == ["enter_initialisation", "exit_initialisation", "closed"]


@pytest.mark.parametrize(("status", "end"), [(ERROR, "freed"), (FATAL, "abandoned")])
def test_a_slave_that_failed_is_freed_unless_fatally_and_the_others_closed(status, end):
    made = bench({"bad": failing(1.0, status), "good": clock()})
    made.run(3)

    assert made.slaves["bad"].events[-1] == end
    assert made.slaves["good"].events[-1] == "closed"


def test_slaves_are_closed_when_one_cannot_be_loaded():
    made = bench({"good": clock(), "bad": clock()})

    def factory(name, description):
        if name == "bad":
            raise FmuError(name, "cannot be loaded: no binary")
        return made.factory(name, description)

    with pytest.raises(FmuError, match=r"^bad: cannot be loaded: no binary$"):
        simulate(made.system, made.schedule, Grid(0.0, 1.0, 1), factory=factory)
    assert made.slaves["good"].events == ["closed"]


def test_two_runs_give_the_same_bits(caplog):
    caplog.set_level(logging.ERROR)
    blocks = {"mass": integrator(), "rate": integrator(), "spring": gain(-4.0)}
    wires = [wire("mass.x", "spring.u"), wire("spring.y", "rate.u"), wire("rate.x", "mass.u")]
    made = bench(blocks, wires, ["spring", "rate", "mass"], step_size=0.01, start={"mass": {"x": 0.3}})

    assert np.array_equal(made.run(300).result.values, made.run(300).result.values)
