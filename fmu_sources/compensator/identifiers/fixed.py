"""
No identification: the process parameters follow from the assumed attribute parameters at any time.

    Y = (a, b, c, d, e) of m_e, k_m, c_m, k_p, c_p                                               (16)

Parameters m_e, k_m, c_m, k_p, c_p, difference_method of the compensator
Source     Paper, Sec. IV-B.1, Eq. 16. Not in the paper as an identifier.
"""

from __future__ import annotations

from typing import Any

from ...framework.arithmetic import Arithmetic
from ..difference import process_parameters, weight
from .framework.identifier import Estimate, Identifier, Measurement


def estimate(measurement: Measurement, x: Any, p: Any, m: Arithmetic) -> Estimate:
    """Return what the assumed parameters give."""
    return Estimate(process_parameters(p, weight(p.difference_method, m)))


IDENTIFIER = Identifier(name="fixed", number=3, held_by=None, estimate=estimate)
