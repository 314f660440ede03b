"""The parameters for people: values, where each comes from, and what is not determined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .tables import LINEAR_PLANT, STEP, TABLES, Table

PRINTED, CHOSEN, FITTED = "printed", "chosen", "fitted to printed numbers"


@dataclass(frozen=True)
class Parameter:
    """Symbol, meaning, unit, its values in the cases S1, S2, E1, E2, and their source."""

    symbol: str
    meaning: str
    unit: str
    values: tuple[str, ...]
    source: str


def _values(value: Callable[[Table], float]) -> tuple[str, ...]:
    return tuple(_spaced(value(table)) for table in TABLES.values())


def _spaced(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ") if value >= 1e4 else f"{value:g}"


PARAMETERS = (
    Parameter(
        "m_s",
        "mass of the spacecraft",
        "kg",
        _values(lambda table: table.loop.m_s),
        f"E2 {PRINTED}; the others {CHOSEN} for the printed frequency",
    ),
    Parameter(
        "m_e",
        "mass of end-effector and manipulator",
        "kg",
        _values(lambda table: table.loop.m_e),
        f"{CHOSEN} within the printed limit of 100; 65 to 100 fit Table 3",
    ),
    Parameter(
        "k_m",
        "stiffness of the manipulator",
        "N/m",
        _values(lambda table: table.loop.k_m),
        f"{FITTED}: c, d, e and the frequency (Table 3); Y(0), roughly (Table 1); 2.6 Hz (Table 2)",
    ),
    Parameter(
        "c_m",
        "damping of the manipulator",
        "N s/m",
        _values(lambda table: table.loop.c_m),
        f"{FITTED}, as k_m",
    ),
    Parameter(
        "k_p",
        "stiffness of the rope",
        "N/m",
        _values(lambda table: table.loop.k_p),
        f"{FITTED}, as k_m; its variation 8e4 sin 2 pi t in Table 2 {PRINTED}",
    ),
    Parameter(
        "c_p", "damping of the rope", "N s/m", _values(lambda table: table.loop.c_p), f"{FITTED}, as k_m"
    ),
    Parameter("s0", "offset at the start", "mm", _values(lambda table: 1e3 * table.offset), PRINTED),
    Parameter("T", "sampling period", "ms", _values(lambda _: 1e3 * STEP), PRINTED),
    Parameter(
        "T_f",
        "time constant of the force sensor",
        "ms",
        _values(lambda table: 1e3 * table.T_f),
        f"S {PRINTED} (no delay); E {CHOSEN}: more than 2.3 ms is necessary for CFDC alone to diverge",
    ),
    Parameter(
        "sigma",
        "standard deviation of the force noise",
        "N",
        _values(lambda table: table.sigma),
        f"R = 0.001 {PRINTED}, a variance",
    ),
    Parameter(
        "hexapod",
        "geometry, masses, motors, controllers",
        "",
        ("README", "README", "README", "README"),
        f"not printed; {CHOSEN}: an assumed rig of its size, in fmu_sources/motion_simulator/README.md",
    ),
    Parameter(
        "linear plant",
        "K_p, w_v, z, dead time",
        "",
        (
            f"{LINEAR_PLANT.K_p:g} 1/s",
            f"{LINEAR_PLANT.w_v:.2f} rad/s",
            f"{LINEAR_PLANT.z:g}",
            f"{1e3 * LINEAR_PLANT.dead_time:g} ms",
        ),
        f"{CHOSEN} close to the hexapod near 1 Hz; all cases the same",
    ),
)
OPEN = (
    "The values of Tables 1 to 3 are not in the text that we have; c, d, e and frequencies are.",
    "Table 3: c/k of the two elements are 2.577 and 0.978 ms; which element has which is free.",
    "Table 3: m_e within 65 to 100 kg, and 0.6 % of the frequency by rounding, are open.",
    "Table 1 gives the printed Y(0) only roughly: c by 12.6 %, d and e by 5.4 %.",
    "T_f, the parameters of the hexapod, P0 and Q of the Kalman filter, lambda of RLS are not printed.",
    "The order of the blocks in Figs. 5, 6, 8 and 9 is not readable: position P, speed PI, "
    "current P assumed.",
)
