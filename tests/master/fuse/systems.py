"""Systems for the fused form: the docking loop without a compensator under every way of coupling."""

from __future__ import annotations

MEMBERS = ["spacecraft", "motion_simulator", "contact", "force_sensor"]


def loop(order, *, wires=(), stop=0.2, start=0.0, **fmus) -> dict:
    """The loop with another order; `wires` are keys by the number of a wire, `fmus` more keys of an FMU."""
    entries = {
        "spacecraft": {"source": "spacecraft", "parameters": {"m_s": 820}, "start": {"s_des": -0.01}},
        "motion_simulator": {"source": "motion_simulator_linear", "start": {"s_act": -0.01}},
        "contact": {"source": "docking_contact"},
        "force_sensor": {"source": "force_sensor", "parameters": {"T_f": 0.01, "sigma": 0.03, "seed": 3}},
    }
    for name, more in fmus.items():
        entries[name] = entries.get(name, {}) | more
    connections = [
        {"from": "spacecraft.s_des", "to": "motion_simulator.s_cmd"},
        {"from": "motion_simulator.s_act", "to": "contact.s_act"},
        {"from": "motion_simulator.v_act", "to": "contact.v_act"},
        {"from": "contact.f_act", "to": "force_sensor.f_act"},
        {"from": "force_sensor.f_mea", "to": "spacecraft.f"},
    ]
    for number, more in dict(wires).items():
        connections[number] |= more
    return {
        "name": "loop",
        "step_size": 0.001,
        "start_time": start,
        "stop_time": start + stop,
        "fmus": entries,
        "coupling": {"order": order},
        "connections": connections,
    }


COUPLINGS = {
    "sequence with delays": loop(MEMBERS, wires={0: {"delay": 3}, 3: {"delay": 1}}, start=2.5),
    "against the loop, extrapolated": loop(
        MEMBERS[::-1],
        wires={0: {"extrapolation": 1}, 1: {"extrapolation": 2}, 4: {"extrapolation": 2, "delay": 2}},
    ),
    "side by side": loop([MEMBERS]),
    "side by side in part, at rates": loop(
        [MEMBERS[:2], *MEMBERS[2:]], force_sensor={"every": 3}, motion_simulator={"every": 2}
    ),
    "iterated": loop([{"iterate": MEMBERS, "tolerance": 1e-9, "maximum": 80}]),
    "iterated in part, at a rate, delayed": loop(
        ["spacecraft", {"iterate": ["motion_simulator", "contact"], "tolerance": 1e-8}, "force_sensor"],
        wires={0: {"delay": 2}, 4: {"extrapolation": 1}},
        motion_simulator={"every": 2},
        contact={"every": 2},
    ),
    "waveform": loop([{"waveform": MEMBERS, "window": 4, "tolerance": 1e-9, "maximum": 200}]),
    "waveform by Jacobi": loop(
        ["spacecraft", {"waveform": MEMBERS[1:], "window": 3, "sweep": "jacobi", "maximum": 200}],
        wires={0: {"extrapolation": 1}, 2: {"delay": 1}},
    ),
}


def with_conversions() -> dict:
    """Two instances of one model, a model whose inputs stay open, and wires that convert."""
    data = loop(
        ["spacecraft", "motion_simulator", "contact", "force_sensor", "other", "free"],
        wires={4: {"factor": -0.5, "offset": 3.0}, 1: {"factor": 1.25}},
        other={"source": "spacecraft", "parameters": {"m_s": 75}, "start": {"v_des": 0.1}},
        free={"source": "spacecraft", "parameters": {"m_s": 3}, "start": {"f": 2.0}},
    )
    data["connections"].append({"from": "contact.f_act", "to": "other.f", "delay": 2})
    return data


EVENTS = {
    "values at times, one over another": [
        {"at": 0.02, "set": {"spacecraft.m_s": 300}, "for": 0.05},
        {"at": 0.05, "set": {"spacecraft.m_s": 1500}, "for": 0.1},
        {"at": 0.0, "set": {"free.f": -7.5}},
        {"at": 0.0601, "set": {"free.f": 4, "free.m_s": 12}, "for": 0.0405},
    ],
    "faults of connections": [
        {"at": 0.03, "offset": {"contact.s_act": 0.002}, "for": 0.02},
        {"at": 0.04, "delay": {"spacecraft.f": 4}, "for": 0.05},
        {"at": 0.045, "freeze": "motion_simulator.s_cmd", "for": 0.012},
        {"at": 0.1, "drop": ["spacecraft.f"], "for": 0.01},
        {"at": 0.02, "jitter": {"contact.v_act": 5}, "seed": 77},
        {"at": 0.13, "jitter": {"contact.v_act": 2}, "seed": 3, "for": 0.01},
    ],
    "under conditions": [
        {"when": "contact.f_act > 20", "set": {"contact.k_p": 20000}, "for": 0.03},
        {"when": "spacecraft.s_des > -0.009", "jitter": {"force_sensor.f_act": 3}},
        {"when": "motion_simulator.s_act < -0.005", "set": {"free.f": 3}, "for": 0.01},
        {"at": 0.09, "offset": {"spacecraft.f": 5.0}},
    ],
}


def with_events(events, order=None, wires=None) -> dict:
    """The loop and a free spacecraft under events; some wires are delayed and extrapolated."""
    return loop(
        order or [*MEMBERS, "free"],
        wires={0: {"delay": 2}, 3: {"extrapolation": 1}} if wires is None else wires,
        free={"source": "spacecraft", "parameters": {"m_s": 3}, "start": {"f": 2.0}},
    ) | {"events": events}
