import gc

import pytest

from master.stepping import pacing
from master.stepping.pacing import STOP, Pacer


class Clock:
    """Time that passes only by sleeping, and by a fixed step each time it is looked at."""

    def __init__(self, look):
        self.now, self.look, self.slept = 100.0, look, []

    def perf_counter(self):
        self.now += self.look
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds


@pytest.fixture
def at(monkeypatch):
    def make(look=1e-6):
        made = Clock(look)
        monkeypatch.setattr(pacing, "time", made)
        return made

    return make


def test_a_tick_waits_for_its_absolute_release(at):
    clock, pacer = at(), Pacer()
    pacer.begin()
    start = clock.now
    for tick in range(5):
        pacer.wait(tick, 0.25)
        assert clock.now == pytest.approx(start + 0.25 * tick, abs=3e-6)  # one look late at most
        clock.now += 0.1  # work does not move the next release


def test_a_factor_shortens_the_ticks(at):
    clock, pacer = at(), Pacer(factor=10.0)
    pacer.begin()
    start = clock.now
    pacer.wait(4, 0.25)

    assert clock.now - start == pytest.approx(0.1, abs=3e-6)


def test_lateness_is_measured_from_the_release(at):
    clock, pacer = at(0.0), Pacer()
    pacer.begin()
    clock.now += 0.004
    pacer.wait(0, 1.0)

    assert pacer.lateness == [pytest.approx(0.004)]


def test_work_beyond_the_next_release_is_an_overrun(at):
    clock, pacer = at(0.0), Pacer()
    pacer.begin()
    clock.now += 0.5
    assert pacer.done(0, 1.0)
    assert pacer.overruns == 0
    clock.now += 1.6
    assert pacer.done(1, 1.0)
    assert pacer.overruns == 1


def test_an_overrun_may_stop_the_run(at):
    clock, pacer = at(0.0), Pacer(on_overrun=STOP)
    pacer.begin()
    clock.now += 2.0

    assert not pacer.done(0, 1.0)


def test_the_report_counts_by_lateness():
    pacer = Pacer(lateness=[0.0, 5e-6, 15e-6, 0.3e-3, 0.25], overruns=3)
    report = pacer.report()

    assert report["histogram"]["0..0.01 ms"] == 2
    assert report["histogram"]["0.01..0.02 ms"] == 1
    assert report["histogram"]["0.2..0.5 ms"] == 1
    assert report["histogram"]["100..inf ms"] == 1
    assert sum(report["histogram"].values()) == 5
    assert (report["worst_ms"], report["worst_tick"], report["overruns"]) == (250.0, 4, 3)
    assert report["median_ms"] == pytest.approx(0.015)


def test_no_garbage_is_collected_between_the_ticks_and_again_afterwards():
    pacer = Pacer()
    with pacer.pacing():
        assert not gc.isenabled()

    assert gc.isenabled()


def test_a_run_without_ticks_reports_nothing():
    assert Pacer().report() == {}
