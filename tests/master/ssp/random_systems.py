"""Random systems of this project's own FMUs, as the YAML form: every way of coupling, drawn from a seed."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

from master.fmi.description import Description, Kind
from master.fmi.description_reader import read_description

FMUS = Path(__file__).parents[3] / "fmus"
SOURCES = (
    "force_sensor",
    "spacecraft",
    "docking_contact",
    "motion_simulator_linear",
    "real_docking",
    "compensator",
)
NAMES = ("a", "B", "sensor_1", "x-y", "über", "a/b", "a_b", "A", "'q'", "100%", "p&q", "[3]")


def random_system(seed: int) -> dict[str, Any]:
    """Draw a system: FMUs, values, wires with delays and all else, order or none, events, limits."""
    draw = random.Random(seed)
    names = draw.sample(NAMES, draw.randint(1, 5))
    fmus = {}
    described: dict[str, Description] = {}
    for name in names:
        folder = FMUS / "fmi3" if draw.random() < 0.3 else FMUS
        source = folder / f"{draw.choice(SOURCES)}.fmu"
        described[name] = read_description(source)
        fmus[name] = {"source": str(source)}
    sampled = any("sample_time" in d.by_name for d in described.values())
    connections = _connections(draw, described)
    taken = {c["to"] for c in connections}
    every = draw.choice([1, 1, 2, 3])
    for name in names:
        fmus[name]["start"] = _values(draw, name, described[name], taken)
        if draw.random() < 0.3:
            fmus[name]["every"] = every
    start_time = draw.choice([0.0, 0.0, -0.25, 1.5])
    data: dict[str, Any] = {
        "name": draw.choice(["system", "a b", "x & <y>", "größe"]),
        "description": draw.choice(["", "a line\nand another", 'quotes " and <tags>']),
        "step_size": draw.choice([1e-3, 2e-3, 5e-3] if sampled else [1e-3, 0.1 / 3, 1 / 7000]),
        "start_time": start_time,
        "fmus": fmus,
        "connections": connections,
    }
    data["stop_time"] = start_time + 20 * data["step_size"]
    if data["stop_time"] <= 0.0:
        data["start_time"], data["stop_time"] = 0.0, 20 * data["step_size"]
    order = _order(draw, names, fmus, connections)
    if order is not None:
        data["coupling"] = {"order": order}
    events = _events(draw, data, described, taken)
    if events:
        data["events"] = events
    if draw.random() < 0.3:
        data["limits"] = {f"{names[0]}.{described[names[0]].outputs[0].name}": 1e9}
    return data


def _connections(draw: random.Random, described: dict[str, Description]) -> list[dict[str, Any]]:
    outputs = [(n, v) for n, d in described.items() for v in d.outputs if v.kind is Kind.REAL]
    latched = [(n, v) for n, v in outputs if not described[n].feedthrough[v.name]]  # close no algebraic loop
    place = {name: i for i, name in enumerate(described)}
    found = []
    for name, d in described.items():
        before = [(n, v) for n, v in outputs if place[n] < place[name]]
        if not before + latched:
            continue
        for v in d.variables:
            if v.causality != "input" or v.kind is not Kind.REAL or draw.random() < 0.4:
                continue
            source, output = draw.choice(before + latched)
            wire: dict[str, Any] = {"from": f"{source}.{output.name}", "to": f"{name}.{v.name}"}
            if output.unit_name != v.unit_name or draw.random() < 0.2:
                wire["units"] = "ignored"
                wire["factor"] = draw.uniform(-0.5, 0.5)
                wire["offset"] = draw.choice([0.0, draw.uniform(-1.0, 1.0)])
            wire["delay"] = draw.choice([0, 0, 1, 1, 5])
            if draw.random() < 0.2:
                wire["extrapolation"] = draw.choice([1, 2])
            found.append(wire)
    draw.shuffle(found)
    return found


def _values(draw: random.Random, name: str, d: Description, taken: set[str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for v in d.variables:
        if v.causality not in ("parameter", "input") or f"{name}.{v.name}" in taken:
            continue
        if v.name == "sample_time" or draw.random() < 0.7:  # no step size fits a sample time by chance
            continue
        if v.kind is Kind.BOOLEAN:
            found[v.name] = draw.random() < 0.5
        elif v.items:
            found[v.name] = draw.choice(list(v.items))
        elif v.kind is Kind.REAL and v.start is not None:
            found[v.name] = float(v.start) * draw.uniform(0.9, 1.0)
    return found


def _order(
    draw: random.Random, names: list[str], fmus: dict[str, Any], connections: list[dict[str, Any]]
) -> list[Any] | None:
    """None where every wire is delayed or leads on, which needs no order."""
    if draw.random() < 0.3:
        place = {name: i for i, name in enumerate(names)}
        for wire in connections:
            ends = [wire[end].partition(".")[0] for end in ("from", "to")]
            if place[ends[0]] >= place[ends[1]]:
                wire["delay"] = max(wire["delay"], 1)
        return None
    left = list(names)
    draw.shuffle(left)
    order: list[Any] = []
    while left:
        group = [left.pop() for _ in range(min(len(left), draw.randint(1, 3)))]
        order.append(group[0] if len(group) == 1 else group)
    if draw.random() < 0.25 and len({fmus[n].get("every", 1) for n in names}) == 1:
        for wire in connections:
            wire.pop("extrapolation", None)
            if draw.random() < 0.5:
                wire["tolerance"] = 1e-6
        return [{"iterate": names, "tolerance": 1e3, "maximum": 7}]
    return order


def _events(
    draw: random.Random, data: dict[str, Any], described: dict[str, Description], taken: set[str]
) -> list[dict[str, Any]]:
    events = []
    middle = data["start_time"] + 7 * data["step_size"]
    for target in sorted(taken):
        if draw.random() < 0.2:
            deed = draw.choice([{"freeze": target}, {"drop": target}, {"offset": {target: 0.125}},
                                {"delay": {target: 2}}, {"jitter": {target: 3}, "seed": 5}])  # fmt: skip
            events.append({"at": middle, "for": 5 * data["step_size"], **deed})
    for name, d in described.items():
        for v in d.variables:
            is_free = v.causality == "input" and v.kind is Kind.REAL and f"{name}.{v.name}" not in taken
            if is_free and draw.random() < 0.2:
                events.append(
                    {"when": f"{name}.{d.outputs[0].name} > -1e9", "set": {f"{name}.{v.name}": 0.5}}
                )
    return events
