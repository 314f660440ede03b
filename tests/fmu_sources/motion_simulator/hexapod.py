"""The hexapod at rest, its linearisation, and its frequency response."""

from __future__ import annotations

import cmath
import math

import numpy as np

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance
from fmu_sources.framework.variables import Role
from fmu_sources.motion_simulator.geometry import leg_lengths
from fmu_sources.motion_simulator.motion_simulator import MODEL

SAMPLE = 1e-3  # s
NEUTRAL = (0.0,) * 6
POSE_STATES = ("x_act", "y_act", "s_act", "roll_act", "pitch_act", "yaw_act")
N = sum(not (v.sampled or v.restarts) for v in MODEL.group(Role.STATE))
PARAMETERS = MODEL.parameters.record([v.start for v in MODEL.group(MODEL.variables[0].role)])


def at_rest(pose=NEUTRAL, model=MODEL, **values):
    """Initialise at a pose with the commands that hold it."""
    instance = Instance(model)
    for i, (name, value) in enumerate(zip(POSE_STATES, pose, strict=True), start=1):
        instance[name] = float(value)
        instance[f"pose_cmd[{i}]"] = float(value)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def read(instance, name, n=6):
    """Elements 1 to n of a vector."""
    return np.array([instance[f"{name}[{i}]"] for i in range(1, n + 1)])


def linearise(pose=NEUTRAL):
    """Derivatives by the continuous states, shape (24, 24), and by the commanded pose, shape (24, 6)."""
    instance = at_rest(pose)
    values = np.array([instance[name] for name in MODEL.states.names])
    u = MODEL.inputs.record([instance[name] for name in MODEL.inputs.names])

    def derivatives(states):
        x = MODEL.states.record(states.tolist())
        return np.array(MODEL.continuous.flat(MODEL.derivatives(0.0, x, u, PARAMETERS, PYTHON)))[:N]

    def lengths(q):
        return np.array(leg_lengths(tuple(q.tolist()), PARAMETERS, PYTHON))

    references = MODEL.states.fields["leg_reference"]
    by_states = jacobian(derivatives, values)
    return by_states[:, :N], by_states[:, references] @ jacobian(lengths, np.array(pose))


def jacobian(function, x, h=1e-3):
    """Central differences of fourth order."""
    weights = ((1, 8 / 12), (-1, -8 / 12), (2, -1 / 12), (-2, 1 / 12))
    columns = [sum(w / h * function(x + k * h * e) for k, w in weights) for e in np.eye(len(x))]
    return np.transpose(columns)


def response(system, frequency, axis=2):
    """Response of a coordinate of the pose to its command [Hz], without sampling and dead time."""
    A, B = system
    return complex(np.linalg.solve(2j * math.pi * frequency * np.eye(N) - A, B[:, axis])[axis])


def phase(value):
    """Angle [deg]."""
    return math.degrees(cmath.phase(value))


def run(instance, n, command=None):
    """Step n periods with s_cmd = command(t); the displacement after each, shape (n,)."""
    found = []
    for k in range(n):
        if command is not None:
            instance["s_cmd"] = command(k * SAMPLE)
        instance.step(k * SAMPLE, SAMPLE)
        found.append(instance["s_act"])
    return np.array(found)
