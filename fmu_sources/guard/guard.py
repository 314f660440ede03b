"""
Guard of a docking rig: energy budget and limits; it passes force and command on until one is exceeded.

    u          = v_des - v                                       speed against the foot of the contact
    v_0^2      = max(u^2 + (|f_mea| + 3 force_noise) |s_des - x|/m_s, least_speed^2)   at the first instant
    v_ref^2(0) = v_0^2
    v_ref^2    = max(min(v_ref^2, U), least_speed^2),   U the larger u^2 of the last two half cycles
    gain       = (1 + tolerance) (1 + variation)/(1 - variation)
    ratio      = u^2/v_ref^2
    alarm        ratio > max(gain, min(gain U/v_ref^2, slow_limit), (1 + tolerance) start_share v_0^2/v_ref^2)
    limits     |s_des| <= largest_displacement,   |s_des - s_act| <= largest_deviation,
               |f_mea| <= largest_force,   |v_des| <= largest_speed                  0: no such limit

A free docking turns energy from the contact into motion and back and loses some: the speed in the middle of a
swing is at most that of the swing before. A delay of the loop adds energy, whatever its cause. A half cycle
ends where u has crossed to HYSTERESIS v_ref on the other side, so that noise at a turning point is none;
of two half cycles the larger counts, so that a drift under the oscillation is no gain. What grows by less
than `gain` from swing to swing may go on until it has slow_limit times the energy of the least swing; 1.8 is
1.34 times the amplitude: 1.5^2 less a tenth that comes in one swing and a tenth for a frequency that falls.
U is v_ref^2(0) before the first half cycle is over. What the rig bore at the start it bears again: a motion
that has shrunk may grow to start_share of that energy; with 0 every gain counts.

    f_safe     = f_comp,  s_safe = s_cmd                                             before the alarm
    f_safe     = 0,       s_safe(k) = s_safe(k-1) + T w(k),  w(k) = exp(-T/rest_time) w(k-1)      from it on
                          w = u at the alarm, at most what was allowed: the command comes to rest

Inputs   s_des, s_act, s_cmd, x [m], v_des, v [m/s], f_mea, f_comp [N]; x and v are travel and speed of the
         drag mechanism, 0 without one
Outputs  f_safe [N], s_safe [m], alarm [1]: 1 from the first excess on, energy_ratio [1],
         reason [1]: 0 none, 1 energy, 2 displacement, 3 deviation, 4 force, 5 speed; the first one stays
States   all sampled; start: force and command as they are, no alarm
Source   Kinetic energy as an indicator of stability: Galmez, Fermandois, Front. Built Env. 6:134 (2020). The
         budget that needs no stiffness, lag or plant is the project's own.
Valid    One axis, a contact that does not supply energy: a stiffness that varies with time does, and is
         declared by `variation`; so does a drag whose speed changes. At the alarm the drag has to be stopped,
         too. Motion slower than `least_speed` is not watched.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Terminal, Values, no_effect
from ..framework.variables import declare, fixed, input_, parameter, sampled, state, switch

HYSTERESIS = 0.1
"""Share of v_ref at which a new half cycle begins."""
NOISE_DEVIATIONS = 3.0
"""Deviations of the noise by which the first force may be too small."""
ENERGY, DISPLACEMENT, DEVIATION, FORCE, SPEED = 1.0, 2.0, 3.0, 4.0, 5.0

PARAMETERS = declare(
    switch("active", True, "The guard watches; else it passes force and command on, whatever happens"),
    parameter("m_s", 820.0, "kg", "Mass of the spacecraft as in its model", above=0.0),
    parameter(
        "tolerance",
        0.05,
        "1",
        "Share by which the kinetic energy may exceed that of previous swings",
        above=0.0,
    ),
    parameter(
        "slow_limit",
        1.8,
        "1",
        "Kinetic energy over its least budget that a slow growth may reach; 1: none",
        minimum=1.0,
    ),
    parameter(
        "start_share",
        1.0,
        "1",
        "Share of the energy at the start that later motion may have however it grows; 0: every gain counts",
        minimum=0.0,
        maximum=1.0,
    ),
    parameter(
        "force_noise",
        0.0,
        "N",
        "Standard deviation of the noise of f_mea; three are added to the first force",
        minimum=0.0,
    ),
    parameter("variation", 0.0, "1", "Share by which stiffness is known to vary", minimum=0.0, maximum=0.9),
    parameter("least_speed", 1e-3, "m/s", "Speed below which nothing is a gain of energy", above=0.0),
    parameter("largest_displacement", 0.0, "m", "Limit of s_des, 0: none", minimum=0.0),
    parameter("largest_deviation", 0.0, "m", "Limit of s_des - s_act, 0: none", minimum=0.0),
    parameter("largest_force", 0.0, "N", "Limit of f_mea, 0: none", minimum=0.0),
    parameter("largest_speed", 0.0, "m/s", "Limit of v_des, 0: none", minimum=0.0),
    parameter("rest_time", 0.05, "s", "Time constant of the command on its way to rest", above=0.0),
    fixed(parameter("sample_time", 1e-3, "s", "Sampling period", above=0.0)),
)
INPUTS = declare(
    input_("s_des", "m", "Desired displacement of the spacecraft"),
    input_("v_des", "m/s", "Desired velocity of the spacecraft"),
    input_("s_act", "m", "Actual displacement of the motion simulator"),
    input_("f_mea", "N", "Measured contact force"),
    input_("x", "m", "Travel of the drag mechanism relative to the end-effector"),
    input_("v", "m/s", "Velocity of the drag mechanism"),
    input_("f_comp", "N", "Compensated force, to be passed on"),
    input_("s_cmd", "m", "Command to the motion simulator, to be passed on"),
)
STATES = declare(
    sampled(state("f_safe", "N", "Force to the spacecraft dynamics", output=True)),
    sampled(state("s_safe", "m", "Command to the motion simulator", output=True)),
    sampled(state("alarm", "1", "1 from the first excess on, else 0", output=True)),
    sampled(
        state(
            "reason",
            "1",
            "0 none, 1 energy, 2 displacement, 3 deviation, 4 force, 5 speed",
            output=True,
        )
    ),
    sampled(state("energy_ratio", "1", "Kinetic energy over its budget", output=True)),
    sampled(state("budget", "m2/s2", "Squared speed v_ref^2 that the motion may have"), hidden=True),
    sampled(state("at_start", "m2/s2", "Squared speed v_0^2 that the motion had at the start"), hidden=True),
    sampled(state("recent", "m2/s2", "Larger squared speed of the last two half cycles"), hidden=True),
    sampled(state("side", "1", "Sign of the speed in this half cycle, 0 before the first"), hidden=True),
    sampled(state("peak", "m2/s2", "Largest squared speed of this half cycle"), hidden=True),
    sampled(state("last_peak", "m2/s2", "Largest squared speed of the half cycle before"), hidden=True),
    sampled(state("rate", "m/s", "Velocity of the command on its way to rest"), hidden=True),
    sampled(state("has_started", "1", "1 after the first sampling period"), hidden=True),
)


def _larger(a: Any, b: Any, m: Arithmetic) -> Any:
    return m.where(a > b, a, b)


def _smaller(a: Any, b: Any, m: Arithmetic) -> Any:
    return m.where(a < b, a, b)


def _excess(size: Any, limit: Any, m: Arithmetic) -> Any:
    """Return 1 where a magnitude is not within a limit that there is."""
    return m.where(limit > 0.0, m.where(size <= limit, 0.0, 1.0), 0.0)


class Guard(Model):
    """Force and command as they come, until energy or a limit is exceeded; then hold."""

    name = "guard"
    description = "Guard of the rig: kinetic-energy budget and limits, and a command that holds"
    variables = declare(PARAMETERS, INPUTS, STATES)
    linear = (Linear("active", "false", "an alarm changes force and command at once and for good"),)
    terminals = (
        Terminal(
            "spacecraft",
            "dynamics",
            "Plug of the dynamics model",
            {"force": "f_safe", "displacement": "s_des", "velocity": "v_des"},
        ),
        Terminal(
            "motion_simulator",
            "motion",
            "Plug of the motion simulator",
            {"command": "s_safe", "displacement": "s_act"},
        ),
    )
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        return {"f_safe": u.f_comp, "s_safe": u.s_cmd}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        least = p.least_speed * p.least_speed
        speed = u.v_des - u.v
        energy = speed * speed
        force = m.fabs(u.f_mea) + NOISE_DEVIATIONS * p.force_noise
        first = _larger(energy + force * m.fabs(u.s_des - u.x) / p.m_s, least, m)
        at_start = m.where(x.has_started > 0.5, x.at_start, first)
        old = m.where(x.has_started > 0.5, x.budget, first)
        gain = (1.0 + p.tolerance) * (1.0 + p.variation) / (1.0 - p.variation)
        ratio = energy / old
        recent = m.where(x.has_started > 0.5, x.recent, old)
        allowed = _larger(gain, _smaller(gain * recent / old, p.slow_limit, m), m)
        of_start = (1.0 + p.tolerance) * p.start_share * at_start
        allowed = _larger(allowed, of_start / old, m)

        needed = HYSTERESIS * m.sqrt(old)
        side = m.where(speed > needed, 1.0, m.where(speed < -needed, -1.0, x.side))
        turns = m.both(side != x.side, x.side != 0.0)
        of_cycle = _larger(x.peak, x.last_peak, m)
        may_fall = m.both(turns, x.last_peak > 0.0)
        budget = m.where(may_fall, _larger(_smaller(old, of_cycle, m), least, m), old)

        reason = m.where(ratio <= allowed, 0.0, ENERGY)
        for size, limit, code in (
            (m.fabs(u.s_des), p.largest_displacement, DISPLACEMENT),
            (m.fabs(u.s_des - u.s_act), p.largest_deviation, DEVIATION),
            (m.fabs(u.f_mea), p.largest_force, FORCE),
            (m.fabs(u.v_des), p.largest_speed, SPEED),
        ):
            reason = m.where(reason > 0.0, reason, code * _excess(size, limit, m))
        reason = m.where(x.alarm > 0.5, x.reason, m.where(p.active, reason, 0.0))
        is_alarm = reason > 0.0

        fastest = m.sqrt(allowed * old)
        limited = _larger(_smaller(speed, fastest, m), -fastest, m)
        rate = m.where(x.alarm > 0.5, x.rate * m.exp(-T / p.rest_time), limited)
        return {
            "f_safe": m.where(is_alarm, 0.0, u.f_comp),
            "s_safe": m.where(is_alarm, x.s_safe + T * rate, u.s_cmd),
            "alarm": m.where(is_alarm, 1.0, 0.0),
            "reason": reason,
            "energy_ratio": ratio,
            "budget": budget,
            "at_start": at_start,
            "recent": m.where(turns, of_cycle, recent),
            "side": side,
            "peak": m.where(turns, energy, _larger(x.peak, energy, m)),
            "last_peak": m.where(turns, x.peak, x.last_peak),
            "rate": rate,
            "has_started": 1.0,
        }


MODEL = Guard()
