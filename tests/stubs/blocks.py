"""Blocks that tests couple: a clock, gains, integrators, what fails, what marks its inputs."""

from __future__ import annotations

from collections.abc import Callable

from master.fmi.description import Kind
from master.fmi.units import Unit
from master.fmi.value_types import BOOLEAN, FLOAT64, INT32, INT_BOOLEAN

from .slave import METRE, Block, Refusal, variables


def clock() -> Block:
    """Output t: the time at the end of the step."""
    return Block(lambda t, h, v: {"t": t + h}, variables(("t", "output")))


def gain(factor: float = 1.0, source: Unit | None = None, target: Unit | None = None) -> Block:
    """Output y = factor*u at once; the input in the unit `target`, the output in the unit `source`."""
    ports = variables(("u", "input", {"unit": target}), ("y", "output", {"unit": source}))
    return Block(lambda t, h, v: {"y": factor * v["u"]}, ports, {"y": ("u",)})


def integrator(unit: Unit | None = None) -> Block:
    """State and output x with x' = u, by the explicit Euler method."""
    state = {"initial": "exact", "unit": unit}
    return Block(
        lambda t, h, v: {"x": v["x"] + h * v["u"]}, variables(("u", "input"), ("x", "output", state))
    )


def growing(factor: float) -> Block:
    """Output y is `factor` times as large after each step."""
    ports = variables(("y", "output", {"initial": "exact", "start": "1", "unit": METRE}))
    return Block(lambda t, h, v: {"y": v["y"] * (factor if h else 1.0)}, ports)


def failing(at: float, status: int, message: str = "") -> Block:
    """A clock that answers with a status in the step that begins at time `at`."""

    def law(t: float, h: float, v: dict[str, float]) -> dict[str, float]:
        if h and t >= at:
            raise Refusal(status, message)
        return {"t": t + h}

    return Block(law, variables(("t", "output")))


def calling(function: Callable[[float], object]) -> Block:
    """A clock that calls a function with the time of each step's begin."""

    def law(t: float, h: float, v: dict[str, float]) -> dict[str, float]:
        if h:
            function(t)
        return {"t": t + h}

    return Block(law, variables(("t", "output")))


def typed(version: int = 2, whole: int = INT32, real: int = FLOAT64) -> Block:
    """Passes on an integer, a Boolean and a real, and counts in an integer."""
    integer = {"kind": Kind.INTEGER, "value_type": whole, "variability": "discrete"}
    boolean_type = INT_BOOLEAN if version == 2 else BOOLEAN
    boolean = {"kind": Kind.BOOLEAN, "value_type": boolean_type, "variability": "discrete"}
    ports = variables(
        ("i", "input", integer),
        ("b", "input", boolean),
        ("r", "input", {"value_type": real}),
        ("i_out", "output", integer),
        ("b_out", "output", boolean),
        ("r_out", "output", {"value_type": real}),
        ("count", "output", integer),
    )

    def law(t: float, h: float, v: dict[str, float]) -> dict[str, float]:
        passed = {f"{name}_out": v[name] for name in ("i", "b", "r")}
        return passed | {"count": v["count"] + (1 if h else 0)}

    feedthrough = {f"{name}_out": (name,) for name in ("i", "b", "r")}
    return Block(law, ports, feedthrough, version=version)


def mark(n_inputs: int = 1) -> Block:
    """Sends the time of its own row and shows what it received when it stepped: seen0, seen1, ..."""
    places = range(n_inputs)
    ports = [(f"u{i}", "input") for i in places] + [(f"seen{i}", "output") for i in places]

    def law(t: float, h: float, v: dict[str, float]) -> dict[str, float]:
        return {"row": t + h} | {f"seen{i}": v[f"u{i}"] for i in places}

    return Block(law, variables(("row", "output"), *ports))
