"""
The motion simulator of Fig. 8: a hexapod with six electric cylinders under a cascade of controllers.

    M_s(q) nu' + C_s(q, nu) nu + G_s(q) = J_lq^T f_a + wrench                      (Sec. III-D)
    f_a    = K2 (KT i - B om) - J K2^2 l'',   om = K2 l'
    L i'   = V - R_a i - Ke om
    V      = Kc (i_ref - beta i),   i_ref = Kvp e_v + Kvi z
    z'     = e_v = K2 Kpp (l_ref - l) - om
    l_ref  = length of the leg at pose_cmd + s_cmd e_z, of the sampling instant dead_time ago

One file an idea: geometry (legs, inverse kinematics), inertia, dynamics, motors, solve, hexapod_variables.

Inputs   pose_cmd [m, rad], s_cmd [m]: read at each sampling instant and held
         wrench [N, N m], f_contact [N]: the new value over the whole step
Outputs  pose, twist, leg_length, leg_force (f_a), flags   direct feedthrough: wrench, f_contact to leg_force
States   x_act, y_act, s_act, roll_act, pitch_act, yaw_act and their velocities: start as set
         motor_current, speed_integral, leg_reference, the line of commands: such that the simulator stands
         still at its start pose under its weight and the wrench of the start
         time at each limit: since the last communication point
Axes     Base: z up, along the docking axis. The pose is that of the platform's joint centre, from the neutral
         pose at `height`; R = R_z(yaw) R_y(pitch) R_x(roll). Twist, wrench: base axes, at the joint centre.
Source   Paper, Sec. III-D, Fig. 8. Parameters of README.md: the paper prints none.
Deviation  The order of the blocks of Fig. 8 is not readable: P for position, PI for speed, P for current.
Valid    Between the stops of the legs: past one, and for a command past one, the model gives a fault.
         abs(pitch_act) < 90 deg. Legs do not spin, joints and bodies are rigid and without play.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial, reduce
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic
from ..framework.model import Delay, Fault, Model, Slot, SlotFunction, Values, no_effect
from .dynamics import Mechanics, accelerations, holding_forces, leg_acceleration, mechanics
from .geometry import angle_rates, leg_lengths
from .hexapod_variables import N_TICKS, VARIABLES
from .motors import Drive, drive, screw

LEGS = range(1, 7)
SLOT_NAMES = tuple(f"leg_force_{i}" for i in LEGS)
COMMANDS = ("s_cmd", *(f"pose_cmd[{i}]" for i in LEGS))
LOADS = ("f_contact", *(f"wrench[{i}]" for i in LEGS))
STOPS = "between l_min - stop_margin and l_max + stop_margin"


class Motion(NamedTuple):
    """What the states and inputs of an instant give."""

    at: Mechanics
    drives: list[Drive]
    acceleration: list[Any]
    rotor: Any


class MotionSimulator(Model):
    """Hexapod with platform, legs, motors and controllers."""

    name = "motion_simulator"
    description = "Motion simulator: hexapod with six electric cylinders and their control cascade"
    sample_time = "sample_time"
    substep = 0.5e-3
    accuracy = 5e-5  # of the motor currents, whose poles are near -2000 1/s
    variables = VARIABLES
    slots = tuple(
        Slot(
            name,
            "N",
            f"Force that resists the motion of leg {i} beside its inertia: the motor's viscous damping",
            {"l": "m", "der_l": "m/s", "load": "N"},
        )
        for i, name in zip(LEGS, SLOT_NAMES, strict=True)
    )
    delays = (
        *(Delay(name, "hold", steps=-0.5, reason="held over the step") for name in (*COMMANDS, *LOADS)),
        *(
            Delay(name, "dead time", seconds="dead_time", reason="line of commanded lengths")
            for name in COMMANDS
        ),
    )
    fault_texts = (
        *(Fault(f"leg_length[{i}]", f"leg {i} is past a stop", STOPS) for i in LEGS),
        *(Fault(f"leg_reference[{i}]", f"leg {i} is commanded past a stop", STOPS) for i in LEGS),
    )

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        at = mechanics(_pose(x), (0.0,) * 6, p, m)
        forces = holding_forces(at, _wrench(u), p)
        currents = tuple(f / (screw(p, m) * p.KT) for f in forces)
        lengths = tuple(leg.l for leg in at.legs)
        return {
            "motor_current": currents,
            "speed_integral": tuple((p.R_a / p.Kc + p.beta) * i / p.Kvi for i in currents),
            "leg_reference": lengths,
            "command_line": lengths * N_TICKS,
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        px, py, pz, *angles = u.pose_cmd
        line = (*leg_lengths((px, py, pz + u.s_cmd, *angles), p, m), *x.command_line)
        ticks = m.floor(p.dead_time / p.sample_time + 0.5)
        return {
            "leg_reference": tuple(m.pick(line[i::6], ticks) for i in range(6)),
            "command_line": line[:-6],
        }

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        motion = _motion(x, u, p, m, slot)
        roll, pitch, yaw = angle_rates(motion.at.R, motion.at.omega)
        ax, ay, az, wx, wy, wz = motion.acceleration
        return {
            "x_act": x.vx_act,
            "y_act": x.vy_act,
            "s_act": x.v_act,
            "roll_act": roll,
            "pitch_act": pitch,
            "yaw_act": yaw,
            "vx_act": ax,
            "vy_act": ay,
            "v_act": az,
            "wx_act": wx,
            "wy_act": wy,
            "wz_act": wz,
            "motor_current": tuple(d.der_current for d in motion.drives),
            "speed_integral": tuple(d.der_integral for d in motion.drives),
            **{f"{name}_time": m.where(at, 1.0, 0.0) for name, at in _at_limits(motion, p, m).items()},
        }

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        motion = _motion(x, u, p, m, slot)
        at, drives, nu, rotor = motion
        pairs = zip(drives, at.legs, at.motions, strict=True)
        limits = _at_limits(motion, p, m).items()
        return {
            "pose": _pose(x),
            "twist": _twist(x),
            "leg_length": tuple(leg.l for leg in at.legs),
            "leg_force": tuple(
                d.force - rotor * leg_acceleration(leg, motion, nu) for d, leg, motion in pairs
            ),
            **{name: m.where(getattr(x, f"{name}_time") > 0.0, True, now) for name, now in limits},
        }

    def faults(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic) -> Sequence[Any]:
        low, high = p.l_min - p.stop_margin, p.l_max + p.stop_margin
        legs = [_outside(length, low, high, m) for length in leg_lengths(_pose(x), p, m)]
        commands = [_outside(length, low, high, m) for length in x.leg_reference]
        only = [m.where(leg, False, command) for leg, command in zip(legs, commands, strict=True)]
        return [*legs, *only]


def _pose(x: Any) -> tuple[Any, ...]:
    return x.x_act, x.y_act, x.s_act, x.roll_act, x.pitch_act, x.yaw_act


def _twist(x: Any) -> tuple[Any, ...]:
    return x.vx_act, x.vy_act, x.v_act, x.wx_act, x.wy_act, x.wz_act


def _wrench(u: Any) -> tuple[Any, ...]:
    fx, fy, fz, *torque = u.wrench
    return (fx, fy, fz + u.f_contact, *torque)


def _outside(value: Any, low: Any, high: Any, m: Arithmetic) -> Any:
    """Say that a value is not between two bounds, as one that is no number is not."""
    return m.where(m.both(value >= low, value <= high), False, True)


def _at_limits(motion: Motion, p: Any, m: Arithmetic) -> dict[str, Any]:
    """Say of each limit whether a leg or its drive is past it, or is no number."""
    drives = motion.drives
    within = {
        "voltage_saturated": [m.fabs(d.V_p) <= p.V_max for d in drives],
        "current_limited": [m.fabs(d.i_pi) <= p.i_max for d in drives],
        "leg_velocity_exceeded": [m.fabs(leg.der_l) <= p.v_max for leg in motion.at.motions],
        "leg_stroke_exceeded": [m.both(leg.l >= p.l_min, leg.l <= p.l_max) for leg in motion.at.legs],
    }
    return {name: m.where(reduce(m.both, legs), False, True) for name, legs in within.items()}


def _motion(x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction) -> Motion:
    at = mechanics(_pose(x), _twist(x), p, m)
    motors = zip(SLOT_NAMES, x.leg_reference, x.motor_current, x.speed_integral, strict=True)
    drives = []
    for (name, l_ref, i, z), leg, motion in zip(motors, at.legs, at.motions, strict=True):
        resistance = partial(_resistance, slot, name, leg.l, motion.der_l)
        drives.append(drive(l_ref - leg.l, motion.der_l, i, z, resistance, p, m))
    K2 = screw(p, m)
    rotor = p.J * K2 * K2
    return Motion(at, drives, accelerations(at, [d.force for d in drives], _wrench(u), rotor, p), rotor)


def _resistance(slot: SlotFunction, name: str, length: Any, der_l: Any, viscous: Any, load: Any) -> Any:
    return slot(name, viscous, l=length, der_l=der_l, load=load)


MODEL = MotionSimulator()
