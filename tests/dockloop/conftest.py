"""Systems that have exact solutions, made of blocks and of shipped models."""

from __future__ import annotations

import pytest

import dockloop as dl


def integrator(unit="m"):
    """x(t + h) = x(t) + h u, u held: exact for a held input."""

    def step(t, h, values, state):
        state["x"] += h * values["u"]
        return {"x": state["x"]}

    return dl.block({"u": f"{unit}/s"}, {"x": (0.0, unit)}, step, state={"x": 0.0})


def spring(k=100.0):
    return dl.block(
        {"x": "m"}, {"f": "N"}, lambda t, h, u: {"f": -u["k"] * u["x"]}, parameters={"k": (k, "N/m")}
    )


@pytest.fixture
def sprung():
    """A mass of 1 kg as an FMU on a spring of 100 N/m as a block, 1 m out, semi-implicit."""
    return dl.load(
        {
            "name": "sprung",
            "stop_time": 0.5,
            "fmus": {
                "mass": {"source": "spacecraft", "parameters": {"m_s": 1}, "start": {"s_des": 1}},
                "spring": spring(),
            },
            "coupling": {"order": ["spring", "mass"]},
            "connections": [
                {"from": "mass.s_des", "to": "spring.x"},
                {"from": "spring.f", "to": "mass.f"},
            ],
        }
    )


def semi_implicit(n, k=100.0, h=1e-3):
    """Displacements of that oscillator by hand."""
    s, v, found = 1.0, 0.0, [1.0]
    for _ in range(n):
        v += h * (-k * s)
        s += h * v
        found.append(s)
    return found
