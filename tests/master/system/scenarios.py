"""Systems of stubs under events."""

from master.system.config import Config, LoadedConfig
from master.system.scenario import make_scenario
from tests.stubs import bench, clock, gain, wire

STOP = 1000.0


def faulted(*events, **more):
    """A clock seen through a connected gain, under events; the step is 1 s, so that t is the row."""
    made = bench({"clock": clock(), "g": gain()}, [wire("clock.t", "g.u", **more)], ["clock", "g"])
    return made, scenario_of(made, *events)


def scenario_of(made, *events):
    config = made.loaded.config.model_dump(by_alias=True) | {"events": list(events), "stop_time": STOP}
    loaded = LoadedConfig(config=Config.model_validate(config), document=made.loaded.document)
    return make_scenario(loaded, made.system)
