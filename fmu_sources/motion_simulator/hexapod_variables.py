"""The declarations of the hexapod: parameters, inputs, states, outputs."""

from __future__ import annotations

import math
from dataclasses import replace

from ..framework.variables import (
    Variable,
    declare,
    fixed,
    input_,
    of_each_step,
    output,
    parameter,
    sampled,
    state,
    vector,
)

N_TICKS = 20
SHORTEST_PERIOD = 1e-3


def _six(variable: Variable, rotational_unit: str) -> tuple[Variable, ...]:
    x, y, z, *rotations = vector(variable, 6)
    return (x, y, z, *(replace(v, unit=rotational_unit) for v in rotations))


GEOMETRY = (
    parameter("base_radius", 1.10, "m", "Radius of the circle of the base joints", above=0.0),
    parameter("platform_radius", 0.75, "m", "Radius of the circle of the platform joints", above=0.0),
    parameter("base_half_angle", math.pi / 15, "rad", "Half the angle of a pair of base joints", minimum=0.0),
    parameter(
        "platform_half_angle", math.pi / 15, "rad", "Half the angle of a pair of platform joints", minimum=0.0
    ),
    parameter(
        "height", 1.35, "m", "Height of the platform's joint plane over the base's, neutral", above=0.0
    ),
    parameter("l_min", 1.20, "m", "Length of a leg at its lower limit switch", above=0.0),
    parameter("l_max", 1.80, "m", "Length of a leg at its upper limit switch", above=0.0),
    parameter("stop_margin", 0.03, "m", "Way from a limit switch to the stop behind it", minimum=0.0),
)

MASSES = (
    parameter("m_p", 450.0, "kg", "Mass of platform and adapter", above=0.0),
    parameter("c_p", 0.12, "m", "Centre of mass of the platform over its joint plane"),
    parameter("I_x", 75.0, "kg m2", "Inertia of the platform about x through its centre of mass", above=0.0),
    parameter("I_y", 75.0, "kg m2", "Inertia of the platform about y through its centre of mass", above=0.0),
    parameter("I_z", 120.0, "kg m2", "Inertia of the platform about z through its centre of mass", above=0.0),
    parameter("m_1", 45.0, "kg", "Mass of a cylinder", above=0.0),
    parameter("c_1", 0.40, "m", "Centre of mass of a cylinder from its base joint", minimum=0.0),
    parameter("I_1", 6.0, "kg m2", "Transverse inertia of a cylinder about its centre of mass", above=0.0),
    parameter("m_2", 18.0, "kg", "Mass of a rod", above=0.0),
    parameter("c_2", 0.40, "m", "Centre of mass of a rod from its platform joint", minimum=0.0),
    parameter("I_2", 2.2, "kg m2", "Transverse inertia of a rod about its centre of mass", above=0.0),
    parameter("g", 9.81, "m/s2", "Gravity, along -z", minimum=0.0),
)

MOTORS = (
    parameter("lead", 0.020, "m", "Way of a leg per turn of its motor", above=0.0),
    parameter("J", 3e-3, "kg m2", "Equivalent inertia of a motor, K2^2 J along the leg", minimum=0.0),
    parameter("B", 4e-3, "N m s/rad", "Equivalent viscous damping of a motor", minimum=0.0),
    parameter("KT", 0.55, "N m/A", "Torque coefficient of a motor", above=0.0),
    parameter("Ke", 0.55, "V s/rad", "Back-EMF coefficient of a motor", minimum=0.0),
    parameter("L", 4e-3, "H", "Inductance of a motor", above=0.0),
    parameter("R_a", 0.45, "Ohm", "Resistance of a motor", minimum=0.0),
    parameter("Kpp", 30.0, "1/s", "Gain of the position controller", above=0.0),
    parameter("Kvp", 1.2, "A s/rad", "Proportional gain of the speed controller", minimum=0.0),
    parameter("Kvi", 25.0, "A/rad", "Integral gain of the speed controller", above=0.0),
    parameter("Kc", 8.0, "V/A", "Gain of the current controller", above=0.0),
    parameter("beta", 1.0, "1", "Feedback coefficient of the current", minimum=0.0),
    parameter("V_max", 300.0, "V", "Largest voltage at a motor", above=0.0),
    parameter("i_max", 40.0, "A", "Largest current that the speed controller asks for", above=0.0),
    parameter("v_max", 0.8, "m/s", "Largest velocity of a leg", above=0.0),
)

SAMPLING = (
    parameter(
        "dead_time",
        2e-3,
        "s",
        "Dead time of the commands, rounded to whole sampling periods",
        minimum=0.0,
        maximum=N_TICKS * SHORTEST_PERIOD,
    ),
    fixed(parameter("sample_time", 1e-3, "s", "Sampling period of the commands", minimum=SHORTEST_PERIOD)),
)

INPUTS = (
    *_six(input_("pose_cmd", "m", "Commanded pose from the neutral one: x, y, z, roll, pitch, yaw"), "rad"),
    *_six(input_("wrench", "N", "Outer force and torque on the platform, base axes"), "N m"),
    input_("s_cmd", "m", "Commanded displacement along the docking axis, added to pose_cmd[3]"),
    input_("f_contact", "N", "Contact force on the platform along the docking axis, added to wrench[3]"),
)

LIMITS = {
    "voltage_saturated": "A motor gets its largest voltage",
    "current_limited": "A speed controller asks for more than the largest current",
    "leg_velocity_exceeded": "A leg is faster than v_max",
    "leg_stroke_exceeded": "A leg is past a limit switch",
}

STATES = (
    state("x_act", "m", "Position of the platform along x", output=True),
    state("y_act", "m", "Position of the platform along y", output=True),
    state("s_act", "m", "Actual displacement along the docking axis z from the neutral pose", output=True),
    state("roll_act", "rad", "Rotation of the platform about x", output=True),
    state("pitch_act", "rad", "Rotation of the platform about y", output=True),
    state("yaw_act", "rad", "Rotation of the platform about z", output=True),
    state("vx_act", "m/s", "Velocity of the platform along x", output=True),
    state("vy_act", "m/s", "Velocity of the platform along y", output=True),
    state("v_act", "m/s", "Velocity of the platform along the docking axis", output=True),
    state("wx_act", "rad/s", "Angular velocity of the platform about x", output=True),
    state("wy_act", "rad/s", "Angular velocity of the platform about y", output=True),
    state("wz_act", "rad/s", "Angular velocity of the platform about z", output=True),
    *vector(state("motor_current", "A", "Current of a motor", output=True), 6),
    *vector(state("speed_integral", "rad", "Integral of a speed error"), 6),
    *(
        of_each_step(state(f"{name}_time", "s", f"{text}: for how long in the step"))
        for name, text in LIMITS.items()
    ),
    *vector(sampled(state("leg_reference", "m", "Length that a drive follows", output=True)), 6),
    *vector(
        sampled(state("command_line", "m", "Commanded lengths under way, newest first"), hidden=True),
        6 * N_TICKS,
    ),
)

OUTPUTS = (
    *_six(output("pose", "m", "Pose from the neutral one: x, y, z, roll, pitch, yaw"), "rad"),
    *_six(output("twist", "m/s", "Velocity and angular velocity of the platform, base axes"), "rad/s"),
    *vector(output("leg_length", "m", "Length of a leg"), 6),
    *vector(output("leg_force", "N", "Force along a leg behind the rotor's inertia, f_a"), 6),
    *(output(name, "1", text, boolean=True) for name, text in LIMITS.items()),
)


VARIABLES = declare(map(fixed, GEOMETRY), map(fixed, MASSES), MOTORS, SAMPLING, INPUTS, STATES, OUTPUTS)
