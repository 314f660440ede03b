"""Which rig fits the columns of a recording: by their units, else by their names. A proposal, never more."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from master.fmi.unit_names import unit

_REFERENCE = re.compile(r"ref|cmd|command|target|setp|desired|des\b|input|^u\b|^u_|excit", re.IGNORECASE)
_QUANTITIES = {
    "position": ("m", r"pos|disp|dist|stroke|way|travel|^[xqsy]\b|^[xqsy]_"),
    "force": ("N", r"forc|load|^f\b|^f_|kraft"),
    "angle": ("rad", r"angl|theta|phi|winkel|rotation|^q\b|^q_"),
    "torque": ("N m", r"torq|moment|^tau"),
    "speed": ("rad/s", r"speed|omega|rpm|gyro"),
    "current": ("A", r"curr|^i\b|^i_|amp"),
    "voltage": ("V", r"volt|^u\b|^u_|^v\b|pwm"),
    "pressure": ("Pa", r"press|^p\b|^p_|^p\d"),
    "temperature": ("K", r"temp|^t_[a-z]"),
    "power": ("W", r"power|heat|^p\b|^p_"),
    "level": ("V", r"level|tank|^h\b|^h_|^h\d"),
}


@dataclass(frozen=True)
class Told:
    """A column by its name, and its unit, "" where nothing tells it."""

    name: str
    unit: str


@dataclass(frozen=True)
class Rig:
    """
    A model of `fmu_sources/rigs` by the quantities that it needs, variable to quantity.

    `also` is compared where it was recorded, `rates` are inputs that are made from others, `set` those that
    are seldom recorded, `refit` what may be a wrong number, `states` the start values that are not known.
    `drifts` where it is replayed in windows.
    `linear`: signals that what is compared is a sum of, each times a parameter above 0; none where it is not.
    """

    source: str
    drives: Mapping[str, str]
    compared: Mapping[str, str]
    refit: Sequence[str]
    also: Mapping[str, str] = field(default_factory=dict)
    rates: Mapping[str, str] = field(default_factory=dict)
    set: Mapping[str, float] = field(default_factory=dict)
    states: Sequence[str] = ()
    drifts: bool = False
    linear: Sequence[str] = ()


@dataclass(frozen=True)
class Proposal:
    """A rig with the column of each of its variables; `compared` those of its outputs that have one."""

    rig: Rig
    columns: Mapping[str, str]

    @property
    def compared(self) -> Sequence[str]:
        """Outputs that were recorded."""
        return [v for v in (*self.rig.compared, *self.rig.also) if v in self.columns]


_ANY = "any"
FOLLOWER = Rig(
    "first_order_follower", {"u": _ANY}, {"y": _ANY}, ("time_constant", "gain", "zero"), states=("y",)
)
RIGS = (
    Rig(
        "servo_axis_inverse",
        {"q": "position"},
        {"force": "force"},
        ("mass", "damping"),
        rates={"der_q": "q", "der_der_q": "der_q"},
        linear=("der_q", "der_der_q"),
    ),
    Rig(
        "motion_driven_specimen",
        {"x": "position"},
        {"force": "force"},
        ("stiffness", "damping"),
        rates={"der_x": "x"},
        set={"load": 0.0},
        linear=("x", "der_x"),
    ),
    Rig(
        "controlled_damper",
        {"x": "position", "control": "current"},
        {"force": "force"},
        ("preload", "stiffness", "damping", "controlled_damping"),
        rates={"der_x": "x"},
    ),
    Rig(
        "controlled_damper",
        {"x": "position", "control": "voltage"},
        {"force": "force"},
        ("preload", "stiffness", "damping", "controlled_damping"),
        rates={"der_x": "x"},
    ),
    Rig(
        "rotary_axis_inverse",
        {"q": "angle"},
        {"torque": "torque"},
        ("inertia", "damping"),
        rates={"der_q": "q", "der_der_q": "der_q"},
        linear=("der_q", "der_der_q"),
    ),
    Rig(
        "cylinder",
        {"p_a": "pressure", "p_b": "pressure"},
        {"q": "position"},
        ("mass", "damping", "area_a", "area_b"),
        set={"load": 0.0},
        states=("q", "der_q"),
        drifts=True,
    ),
    Rig(
        "ball_and_beam",
        {"angle": "angle"},
        {"q": "position"},
        ("damping",),
        rates={"der_angle": "angle"},
        states=("q", "der_q"),
        drifts=True,
    ),
    Rig(
        "thermal_body",
        {"power": "power"},
        {"temperature": "temperature"},
        ("heat_capacity", "conductance"),
        set={"ambient": 293.15},
        states=("temperature",),
    ),
    Rig(
        "thermal_body",
        {"power": "power", "ambient": "temperature"},
        {"temperature": "temperature"},
        ("heat_capacity", "conductance"),
        states=("temperature",),
    ),
    Rig(
        "two_tanks",
        {"u": "voltage"},
        {"h_2": "level"},
        ("pump_gain", "upper_rate", "lower_rate"),
        states=("h_2",),
    ),
    Rig(
        "rotary_axis",
        {"i": "current"},
        {"q": "angle"},
        ("inertia", "damping"),
        also={"der_q": "speed"},
        states=("q", "der_q"),
        drifts=True,
    ),
    Rig(
        "dc_motor",
        {"u": "voltage"},
        {"der_q": "speed"},
        ("motor_constant", "inertia", "damping"),
        states=("der_q",),
    ),
    Rig(
        "dc_motor",
        {"u": "voltage"},
        {"der_q": "speed", "i": "current"},
        ("resistance", "inductance", "motor_constant", "inertia", "damping"),
        also={"q": "angle"},
        states=("i", "q", "der_q"),
    ),
    Rig(
        "dc_motor",
        {"u": "voltage"},
        {"der_q": "speed", "q": "angle"},
        ("motor_constant", "inertia", "damping"),
        states=("q", "der_q"),
        drifts=True,
    ),
    Rig(
        "pendulum",
        {"torque": "torque"},
        {"q": "angle", "der_q": "speed"},
        ("inertia", "damping", "gravity_torque"),
        states=("q", "der_q"),
    ),
    Rig(
        "two_masses",
        {"f": "force"},
        {"q_1": "position", "q_2": "position"},
        ("mass_1", "mass_2", "stiffness", "coupling_damping", "damping"),
        states=("q_1", "der_q_1", "q_2", "der_q_2"),
        drifts=True,
    ),
    Rig(
        "position_servo",
        {"q_ref": "angle"},
        {"q": "angle"},
        ("inertia", "stiffness", "damping", "gravity_torque"),
        states=("q",),
    ),
    Rig(
        "servo_axis_driven",
        {"v": "voltage"},
        {"q": "position"},
        ("mass", "damping"),
        states=("q", "der_q"),
        drifts=True,
    ),
    Rig("oscillator", {"u": "voltage"}, {"y": "voltage"}, ("mass", "damping", "stiffness"), states=("y",)),
)


def quantities_of(column: Told) -> tuple[Sequence[str], bool]:
    """What a column may measure, the likeliest first; and whether its unit tells it."""
    patterns = {name: re.compile(pattern, re.IGNORECASE) for name, (_, pattern) in _QUANTITIES.items()}
    fitting = [name for name, pattern in patterns.items() if pattern.search(column.name)]
    if not column.unit:
        return fitting, False
    exponents = unit(column.unit).exponents
    if "level" in fitting and exponents in ({"m": 1}, unit("V").exponents):
        return ["level"], True
    same = [name for name, (si, _) in _QUANTITIES.items() if unit(si).exponents == exponents]
    by_name = [name for name in same if name in fitting]
    if same:
        return (by_name or same)[:1], True
    return ([], True) if exponents else (fitting, False)


def proposed(columns: Sequence[Told]) -> list[Proposal]:
    """Rigs that explain most of the columns, all with as many; none with fewer than two columns."""
    if len(columns) < 2:
        return []
    found = [own for rig in RIGS if (own := _matched(rig, columns)) is not None]
    most = max((len(own.columns) for own in found), default=0)
    best = [own for own in found if len(own.columns) == most]
    follower = _matched(FOLLOWER, columns)
    return best or ([] if follower is None else [follower])


def _matched(rig: Rig, columns: Sequence[Told]) -> Proposal | None:
    """A rig with columns for all it needs, or None; what drives is rather called a reference."""
    free = list(columns)
    taken: dict[str, str] = {}
    for variable, quantity in (*rig.drives.items(), *rig.compared.items(), *rig.also.items()):
        is_driven = variable in rig.drives
        found = _likeliest(free, quantity, is_driven=is_driven)
        if found is not None:
            taken[variable] = found.name
            free.remove(found)
        elif variable not in rig.also:
            return None
    return Proposal(rig, taken)


def _likeliest(columns: Sequence[Told], quantity: str, *, is_driven: bool) -> Told | None:
    """A column that may measure a quantity, rather one whose unit tells it, or that is likeliest this."""

    def unlikely(column: Told) -> tuple[bool, bool, bool]:
        may_be, is_told = quantities_of(column)
        return bool(_REFERENCE.search(column.name)) != is_driven, not is_told, quantity not in may_be[:1]

    fitting = [c for c in columns if quantity == _ANY or quantity in quantities_of(c)[0]]
    return min(fitting, key=unlikely, default=None)
