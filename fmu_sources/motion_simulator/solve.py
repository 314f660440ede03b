"""
Solution of M x = b by M = L D L^T, for a symmetric positive definite matrix of order 6.

    e_ij = M_ij - sum_{k<j} L_ik e_jk,   D_j = e_jj,   L_ij = e_ij / D_j                 column after column
    L y = b,   x_j = y_j / D_j - sum_{i>j} L_ij x_i

Written out: loops would take most of the time of a step in Python. Such a matrix needs no pivoting.
Source: Golub, Van Loan, Matrix Computations, 4th ed., Sec. 4.1.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def solve(matrix: Sequence[Sequence[Any]], b: Sequence[Any]) -> list[Any]:
    """Solve M x = b; `matrix` holds the lower triangle by rows, row i with i + 1 elements."""
    (l21, l31, l41, l51, l61), (l32, l42, l52, l62), (l43, l53, l63), (l54, l64), l65, per_d = _factor(matrix)
    y1, y2, y3, y4, y5, y6 = b
    y2 = y2 - l21 * y1
    y3 = y3 - l31 * y1 - l32 * y2
    y4 = y4 - l41 * y1 - l42 * y2 - l43 * y3
    y5 = y5 - l51 * y1 - l52 * y2 - l53 * y3 - l54 * y4
    y6 = y6 - l61 * y1 - l62 * y2 - l63 * y3 - l64 * y4 - l65 * y5
    p1, p2, p3, p4, p5, p6 = per_d
    x6 = y6 * p6
    x5 = y5 * p5 - l65 * x6
    x4 = y4 * p4 - l54 * x5 - l64 * x6
    x3 = y3 * p3 - l43 * x4 - l53 * x5 - l63 * x6
    x2 = y2 * p2 - l32 * x3 - l42 * x4 - l52 * x5 - l62 * x6
    x1 = y1 * p1 - l21 * x2 - l31 * x3 - l41 * x4 - l51 * x5 - l61 * x6
    return [x1, x2, x3, x4, x5, x6]


def _factor(matrix: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
    """Columns of L below the diagonal, and 1/D."""
    (e11,), (e21, e22), (e31, e32, e33), (e41, e42, e43, e44), row_5, row_6 = matrix
    (e51, e52, e53, e54, e55), (e61, e62, e63, e64, e65, e66) = row_5, row_6
    p1 = 1.0 / e11
    l21, l31, l41, l51, l61 = e21 * p1, e31 * p1, e41 * p1, e51 * p1, e61 * p1
    e22 = e22 - l21 * e21
    e32 = e32 - l31 * e21
    e42 = e42 - l41 * e21
    e52 = e52 - l51 * e21
    e62 = e62 - l61 * e21
    p2 = 1.0 / e22
    l32, l42, l52, l62 = e32 * p2, e42 * p2, e52 * p2, e62 * p2
    e33 = e33 - l31 * e31 - l32 * e32
    e43 = e43 - l41 * e31 - l42 * e32
    e53 = e53 - l51 * e31 - l52 * e32
    e63 = e63 - l61 * e31 - l62 * e32
    p3 = 1.0 / e33
    l43, l53, l63 = e43 * p3, e53 * p3, e63 * p3
    e44 = e44 - l41 * e41 - l42 * e42 - l43 * e43
    e54 = e54 - l51 * e41 - l52 * e42 - l53 * e43
    e64 = e64 - l61 * e41 - l62 * e42 - l63 * e43
    p4 = 1.0 / e44
    l54, l64 = e54 * p4, e64 * p4
    e55 = e55 - l51 * e51 - l52 * e52 - l53 * e53 - l54 * e54
    e65 = e65 - l61 * e51 - l62 * e52 - l63 * e53 - l64 * e54
    p5 = 1.0 / e55
    l65 = e65 * p5
    e66 = e66 - l61 * e61 - l62 * e62 - l63 * e63 - l64 * e64 - l65 * e65
    p6 = 1.0 / e66
    columns = (l21, l31, l41, l51, l61), (l32, l42, l52, l62), (l43, l53, l63), (l54, l64), l65
    return *columns, (p1, p2, p3, p4, p5, p6)
