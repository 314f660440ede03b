"""
Contact force delay compensation (CFDC): the force that the missing displacement would add.

    ds(k)   = s_des(k) - s_act(k)
    dF(k)   = a dF(k-1) + b dF(k-2) - c ds(k) - d ds(k-1) - e ds(k-2)                            (17)
    f_des   = f + dF                                                                             (18)

Source   Paper, Sec. IV-B.1, Eqs. 17, 18.
Deviation  The paper prints plus for c, d, e; the contact force is restoring, so dF = -G ds.
"""

from __future__ import annotations

from typing import Any


def correction(Y: tuple[Any, ...], dF: tuple[Any, Any], ds: tuple[Any, Any, Any]) -> Any:
    """Give dF(k) [N] from dF(k-1), dF(k-2) [N] and ds(k), ds(k-1), ds(k-2) [m]."""
    a, b, c, d, e = Y
    return a * dF[0] + b * dF[1] - (c * ds[0] + d * ds[1] + e * ds[2])
