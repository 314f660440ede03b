"""Events act in their own tick and no step goes beyond the stop time, at whatever time a run starts."""

from __future__ import annotations

import itertools
import random
from fractions import Fraction

import pytest

from master.errors import ConfigError
from master.system.config import Config, LoadedConfig
from master.system.grid import Grid, ticks_between
from master.system.scenario import make_scenario
from tests.stubs import bench, clock, integrator

YEAR, UNIX = 31536000.0, 1764453600.0
GRIDS = [
    (0.0, "0.001"),
    (YEAR, "0.001"),
    (YEAR, "0.002"),
    (UNIX, "0.001"),
    (UNIX, "0.002"),
    (1e7, "0.00001"),
    (-5.0, "0.001"),
    (-1e7, "0.002"),
]


def written(t0, h, tick):
    """The time of a tick as a person writes it: in decimals, without a rounding."""
    return float(Fraction(str(t0)) + tick * Fraction(h))


def made_with(t0, h, n_ticks, *events):
    """An integrator whose free input an event sets; it counts the steps that begin after the event."""
    made = bench({"clock": clock(), "x": integrator()}, [], step_size=float(h))
    config = made.loaded.config.model_dump(by_alias=True)
    config |= {"start_time": t0, "stop_time": written(t0, h, n_ticks), "events": list(events)}
    loaded = LoadedConfig(config=Config.model_validate(config), document=made.loaded.document)
    return made, loaded.config, make_scenario(loaded, made.system)


@pytest.mark.parametrize(("t0", "h"), GRIDS)
def test_an_event_at_the_time_of_a_tick_acts_from_that_tick_to_its_end(t0, h):
    choose = random.Random(f"{t0} {h}")
    n = 1000
    for tick in [0, 1, n - 1, *(choose.randrange(n) for _ in range(6))]:
        lasting = choose.randint(1, 50)
        event = {"at": written(t0, h, tick), "for": float(lasting * Fraction(h)), "set": {"x.u": 1.0}}
        made, config, scenario = made_with(t0, h, n, event)
        assert config.n_ticks == n
        values = made.run(n, t0=t0, scenario=scenario).result["x.x"] / float(h)

        steps = [round(b - a) for a, b in itertools.pairwise(values)]
        assert steps == [1 if tick <= k < tick + lasting else 0 for k in range(n)]


def test_an_event_between_two_ticks_acts_from_the_later_one():
    made, _, scenario = made_with(YEAR, "0.001", 10, {"at": YEAR + 0.0035, "set": {"x.u": 1.0}})
    values = made.run(10, t0=YEAR, scenario=scenario).result["x.x"]

    assert [round(1e3 * v) for v in values] == [0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6]


def test_an_event_after_the_begin_of_the_last_step_is_refused_as_it_would_be_lost():
    with pytest.raises(ConfigError) as caught:
        made_with(YEAR, "0.001", 10, {"at": YEAR + 0.0095, "set": {"x.u": 1.0}})

    assert caught.value.problems == [
        "bench.yaml:1: events[0]: after the begin of the last step, so that it would not act, "
        "got at 31536000.0095 s, expected at most 31536000.009 s"
    ]


def test_the_number_of_ticks_is_that_of_the_written_times():
    assert ticks_between(31536000.0, 31536000.999, 0.001) == 999
    assert ticks_between(1764453600.1, 1764453600.4, 0.001) == 300
    assert ticks_between(-5.0, 0.0, 0.001) == 5000


@pytest.mark.parametrize(("t0", "h"), GRIDS)
@pytest.mark.parametrize("every", [1, 3])
def test_the_fmu_is_told_a_stop_time_that_no_step_exceeds(t0, h, every):
    n, step = 999, float(h)
    seen = []
    blocks = {"x": clock()}
    made = bench(blocks, step_size=step, every={"x": every})
    plain = blocks["x"].law
    object.__setattr__(blocks["x"], "law", lambda t, h, v: (seen.append(t + h), plain(t, h, v))[1])
    made.run(n, t0=t0)
    stop = made.slaves["x"].stop

    assert max(seen) <= stop
    assert stop == pytest.approx(t0 + n * step, rel=4e-16)


def test_a_stop_time_of_zero_ends_a_run_that_starts_before():
    made, config, _ = made_with(-5.0, "0.001", 5000)

    assert (config.stop_time, config.n_ticks) == (0.0, 5000)
    assert made.run(5000, t0=-5.0).result.time[-1] == 0.0


def test_a_run_of_no_ticks_stops_where_it_starts():
    assert Grid(7.0, 0.1, 0).stop() == 7.0
