"""What the analysis has to know of compensator and contact: neither is linear and constant in a run."""

from __future__ import annotations

from master.analysis.conventions import Conventions, Learning, Varying

CONVENTIONS = Conventions(
    learning=Learning(
        hold="identification_held",
        off=("identifier", "fixed"),
        when_held="identification is not linear: its process parameters stay as a run leaves them",
        when_off="identification is not linear: its process parameters are the assumed ones",
    ),
    varying=(
        Varying("k_p_amplitude", "k_p_frequency", "a stiffness that varies with time stays at its mean"),
    ),
)
