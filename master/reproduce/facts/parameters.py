"""The tables of parameters: values, where each comes from, and what is not determined."""

from __future__ import annotations

from dataclasses import dataclass

PRINTED, CHOSEN, FITTED = "printed", "chosen", "fitted to printed numbers"


@dataclass(frozen=True)
class Parameter:
    """Symbol, meaning, unit, its values in the cases S1, S2, E1, E2, and their source."""

    symbol: str
    meaning: str
    unit: str
    values: tuple[str, str, str, str]
    source: str


PARAMETERS = (
    Parameter(
        "m_s",
        "mass of the spacecraft",
        "kg",
        ("820", "1000", "4000", "1000"),
        f"E2 {PRINTED}; the others {CHOSEN} for the printed frequency",
    ),
    Parameter(
        "m_e",
        "mass of end-effector and manipulator",
        "kg",
        ("80", "60", "100", "100"),
        f"{CHOSEN} within the printed limit of 100; 65 to 100 fit Table 3",
    ),
    Parameter(
        "k_m",
        "stiffness of the manipulator",
        "N/m",
        ("150 000", "800 000", "139 200", "139 200"),
        f"{FITTED}: c, d, e and the frequency (Table 3); Y(0), roughly (Table 1); 2.6 Hz (Table 2)",
    ),
    Parameter(
        "c_m", "damping of the manipulator", "N s/m", ("158", "800", "136.1", "136.1"), f"{FITTED}, as k_m"
    ),
    Parameter(
        "k_p",
        "stiffness of the rope",
        "N/m",
        ("37 900", "400 000", "37 760", "37 760"),
        f"{FITTED}, as k_m; its variation 8e4 sin 2 pi t in Table 2 {PRINTED}",
    ),
    Parameter("c_p", "damping of the rope", "N s/m", ("65", "400", "97.3", "97.3"), f"{FITTED}, as k_m"),
    Parameter("s0", "offset at the start", "mm", ("-10", "-10", "-5", "-5"), PRINTED),
    Parameter("T", "sampling period", "ms", ("1", "1", "1", "1"), PRINTED),
    Parameter(
        "T_f",
        "time constant of the force sensor",
        "ms",
        ("0", "0", "10", "10"),
        f"S {PRINTED} (no delay); E {CHOSEN}: more than 2.3 ms is necessary for CFDC alone to diverge",
    ),
    Parameter(
        "sigma",
        "standard deviation of the force noise",
        "N",
        ("0.0316", "0.0316", "0.0316", "0.0316"),
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
        ("30 1/s", "2 pi 20 rad/s", "0.8", "2 ms"),
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
