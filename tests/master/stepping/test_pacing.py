import ctypes
import gc

import numpy as np
import pytest

from master.fmi.native import calls
from master.stepping import pacing
from master.stepping.machine import pace
from master.stepping.pacing import CONTINUE, STOP, Pacer
from tests.stubs import Block, bench, variables

MS = 1_000_000


class Clock:
    """Time that passes by sleeping, by a fixed step each time it is looked at, and by work."""

    def __init__(self, look=1000):
        self.now = 5_000_000_000
        self.look = look
        self.slept = []
        self.functions = (
            ctypes.CFUNCTYPE(*calls.CLOCK_SLEEP)(self.sleep),
            ctypes.CFUNCTYPE(*calls.CLOCK_TIME)(self.tell),
        )

    def sleep(self, _, __, place, ___):
        seconds, nanoseconds = (ctypes.c_int64 * 2).from_address(place)
        self.slept.append(seconds * 10**9 + nanoseconds)
        self.now = max(self.now, self.slept[-1])
        return 0

    def tell(self, _, place):
        self.now += self.look
        (ctypes.c_int64 * 2).from_address(place)[:] = list(divmod(self.now, 10**9))
        return 0

    def monotonic_ns(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(pacing, "time", made)
    addresses = [ctypes.cast(f, ctypes.c_void_p).value for f in made.functions]
    monkeypatch.setattr(pacing, "_clock_functions", lambda: addresses)
    monkeypatch.setattr(Pacer, "_ask_the_system", lambda self: None)  # it is for the whole process
    return made


def run(clock, n, work, *, pacer, compiled=False, h=0.25):
    """Run n ticks; `work` gives how long the one that begins at a time takes [ns]."""
    begun = []

    def law(t, h, values):
        if h:
            begun.append(clock.now)
            clock.now += work(round(t / h))
        return {"y": values["y"] + 1.0}

    made = bench({"a": Block(law, variables(("y", "output")))}, [], step_size=h)
    return made.run(n, pacer=pacer, compiled=compiled), begun


@pytest.mark.parametrize("compiled", [False, True])
def test_a_tick_waits_for_its_absolute_release_whatever_the_work_before_took(clock, compiled):
    outcome, begun = run(clock, 8, lambda k: 100 * MS, pacer=Pacer(), compiled=compiled)
    apart = np.diff(begun)

    assert outcome.status == "completed"
    assert np.abs(apart - 250 * MS).max() <= 2 * clock.look
    assert outcome.real_time["overruns"] == 0
    assert sum(outcome.real_time["histogram"].values()) == 8


def test_a_factor_shortens_the_ticks(clock):
    _, begun = run(clock, 5, lambda k: MS, pacer=Pacer(factor=10.0))

    assert np.abs(np.diff(begun) - 25 * MS).max() <= 2 * clock.look


def test_a_tick_after_one_that_took_too_long_is_late_and_says_why(clock):
    outcome, _ = run(clock, 8, lambda k: 300 * MS if k == 2 else MS, pacer=Pacer(factor=1.0), h=0.25)
    report = outcome.real_time
    worst = report["worst"][0]

    assert (report["overruns"], worst["tick"], report["worst_tick"]) == (1, 3, 3)
    assert worst["late_ms"] == pytest.approx(50.0, abs=0.1)
    assert report["worst_ms"] == worst["late_ms"]
    assert report["histogram"]["10..100 ms"] == 1
    assert report["median_ms"] <= 0.003


def test_within_a_chunk_the_cause_is_the_work_of_the_tick_before(clock):
    """Chunks are 0.1 s: ten ticks of 10 ms."""
    outcome, _ = run(clock, 20, lambda k: 15 * MS if k == 4 else 1000, pacer=Pacer(), h=0.01)
    worst = outcome.real_time["worst"][0]

    assert worst["tick"] == 5
    assert worst["cause"].startswith("the tick before took 15.00")


@pytest.mark.parametrize("compiled", [False, True])
def test_an_overrun_may_stop_the_run_and_its_row_stays(clock, compiled):
    def work(k):
        return 600 * MS if k == 3 else MS

    stopped, _ = run(clock, 8, work, pacer=Pacer(on_overrun=STOP), compiled=compiled)

    assert (stopped.status, stopped.steps, len(stopped.result.time)) == ("overrun", 4, 5)
    assert stopped.cause == "tick 3 was not done in time"
    going_on, _ = run(clock, 8, work, pacer=Pacer(on_overrun=CONTINUE), compiled=compiled)
    assert (going_on.status, going_on.real_time["overruns"]) == ("completed", 2)


def test_it_sleeps_until_a_part_of_the_period_before_the_release(clock):
    _, begun = run(clock, 3, lambda k: MS, pacer=Pacer(), h=0.0001)

    assert begun[0] - clock.slept[0] == pytest.approx(30_000, abs=3000)  # 0.3 of 100 us


def test_no_garbage_is_collected_between_the_ticks_and_again_afterwards(clock):
    pacer = Pacer()
    with pacer.pacing(0.001, np.empty(3)):
        assert not gc.isenabled()

    assert gc.isenabled()


def test_the_bins_of_the_table_are_those_of_the_report(clock):
    pacer = Pacer()
    with pacer.pacing(0.001, np.empty(3)):
        cells = pacer._cells
        for late_us in (0, 5, 15, 300, 250_000):
            cells[pace.HISTOGRAM + min(late_us, pace.N_BINS - 1)] += 1
        cells[pace.TICKS] = 5
        cells[pace.WORST] = 250_000_000
        found = pacer.report()

    assert found["histogram"]["0..0.01 ms"] == 2
    assert found["histogram"]["0.01..0.02 ms"] == 1
    assert found["histogram"]["0.2..0.5 ms"] == 1
    assert (found["histogram"]["10..100 ms"], found["histogram"]["100..inf ms"]) == (0, 1)
    assert found["median_ms"] == pytest.approx(0.016)
    assert found["worst_ms"] == 250.0


def test_a_run_without_ticks_reports_nothing():
    assert Pacer().report() == {}
