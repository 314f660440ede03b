"""Numbers of the virtual rig: its parts, what may be wrong with it, how it is recorded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple


class Plant(NamedTuple):
    """Linear parts, SI units: spacecraft, contact, motion simulator, sensor."""

    m_s: float = 1000.0
    m_e: float = 100.0
    k_m: float = 139_200.0
    c_m: float = 136.1
    k_p: float = 37_760.0
    c_p: float = 97.3
    position_gain: float = 30.0
    velocity_bandwidth: float = 125.66370614359172
    velocity_damping: float = 0.8
    dead_time_ticks: float = 2.0
    T_f: float = 0.010


class Effects(NamedTuple):
    """What may be wrong with the rig; zero is off."""

    # contact, in the rope: elongation r
    slack: float = 0.0  # elongation beyond which the rope carries nothing [m]
    cubic: float = 0.0  # [N/m3]
    quadratic_stiffness: float = 0.0  # [N/m2]
    backlash: float = 0.0  # half width of the gap [m]
    bouc_wen: float = 0.0  # force [N], builds up over 1 mm
    end_stop: float = 0.0  # stiffness beyond 2.5 mm [N/m]
    # contact, in the guide: velocity of the end-effector
    coulomb: float = 0.0  # [N]
    stribeck: float = 0.0  # additional force near standstill [N], falls over 5 mm/s
    dahl: float = 0.0  # force [N], builds up over 0.2 mm
    presliding: float = 0.0  # slip force [N] behind a spring that yields 0.3 mm
    quadratic_damping: float = 0.0  # [N s2/m2]
    asymmetric_friction: float = 0.0  # [N] in forward motion, a third of it backward
    load_friction: float = 0.0  # share of the rope's force
    ripple: float = 0.0  # force [N] that repeats every 0.7 mm
    # sensor
    offset: float = 0.0  # [N]
    drift: float = 0.0  # [N/s]
    gain: float = 0.0  # relative
    lag: float = 0.0  # time constant of a second lag [s]
    slow_filter: float = 0.0  # added to T_f [s]
    delay: float = 0.0  # [s]
    quantisation: float = 0.0  # [N]
    inertia: float = 0.0  # mass between contact and sensor [kg]
    mount: float = 0.0  # share that a mode at 25 Hz, damping 2 %, carries
    force_limit: float = 0.0  # end of the sensor's range [N]
    # motion simulator
    rate_limit: float = 0.0  # largest rate at which the command is followed [m/s]
    speed_limit: float = 0.0  # largest velocity that the position loop asks for [m/s]
    simulator_delay: float = 0.0  # more dead time of the command [ticks]
    simulator_gain: float = 0.0  # of the command, relative
    # spacecraft and compensator
    spacecraft_offset: float = 0.0  # force that is added [N]
    command_quantisation: float = 0.0  # [m]
    correction_saturation: float = 0.0  # limit of dF [N]
    # of no listed kind
    hertz: float = 0.0  # force K max(r, 0)^1.5 [N/m^1.5]
    position_friction: float = 0.0  # friction that changes from 0 to twice this [N] along x_e
    thermal: float = 0.0  # share of k_p lost with 4 s
    preisach: float = 0.0  # force [N] of play operators with unequal weights
    asymmetric_slack: float = 0.0  # elongation beyond which 70 % is lost, soft, on one side [m]
    varying_delay: float = 0.0  # largest dead time of the sensor, swinging with 0.7 Hz [s]


LISTED = Effects._fields[: Effects._fields.index("hertz")]
UNLISTED = Effects._fields[Effects._fields.index("hertz") :]
FIRST_OF = {
    **{"slack": "contact", "offset": "force_sensor", "rate_limit": "motion_simulator"},
    **{"spacecraft_offset": "spacecraft", "command_quantisation": "compensator"},
    **{"hertz": "contact", "varying_delay": "force_sensor"},
}


def _subsystems() -> Iterator[tuple[str, str]]:
    current = ""
    for kind in Effects._fields:
        current = FIRST_OF.get(kind, current)
        yield kind, current


SUBSYSTEM = dict(_subsystems())


class Recorder(NamedTuple):
    """Imperfections of the recording."""

    sigma: float = 0.5  # of the force [N]
    colour: float = 0.0  # autoregressive coefficient of the force noise, its standard deviation stays
    sigma_s: float = 2e-6  # of s_act [m]
    sigma_v: float = 5e-5  # of v_act [m/s]
    step_f: float = 0.02  # of the converter [N]
    step_s: float = 1e-6  # of the encoder [m]
    clock_error: float = 0.0  # true tick over recorded tick, minus 1
