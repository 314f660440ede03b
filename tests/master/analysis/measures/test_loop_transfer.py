"""The transfer of an opened loop is that of the matrices it was made from."""

from __future__ import annotations

import numpy as np

from master.analysis.closed_loop.tick_matrix import OpenedLoop
from master.analysis.measures.loop_transfer import LoopTransfer

Z = np.exp(1j * np.geomspace(1e-4, np.pi, 40))


def test_a_delay_line_of_hundreds_of_values_is_a_power_of_z():
    """A signal r enters a line of 300 values, v leaves it halved, 2 r past it: L = 0.5 z^-300 + 2."""
    n = 300
    source, reader = np.zeros((n, 1)), np.zeros((1, n))
    source[0], reader[0, -1] = 1.0, 0.5

    loop = LoopTransfer(OpenedLoop(np.eye(n, k=-1), source, reader, np.array([[2.0]])))

    np.testing.assert_allclose(loop.at(Z), 0.5 * Z**-300.0 + 2.0, atol=1e-11)


def test_modes_that_oscillate_and_one_on_the_circle_are_in_it():
    """Residues of x+ = diag(p) x + r in another basis: L = sum of 1/(z - p)."""
    turn = 0.99 * np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    M = np.zeros((3, 3))
    M[:2, :2], M[2, 2] = turn, 1.0
    basis = np.array([[1.0, 2.0, 0.0], [0.5, -1.0, 3.0], [0.0, 1.0, 1.0]])
    N, P = np.array([[1.0], [0.0], [1.0]]), np.array([[1.0, 0.0, 1.0]])

    loop = LoopTransfer(
        OpenedLoop(basis @ M @ np.linalg.inv(basis), basis @ N, P @ np.linalg.inv(basis), np.zeros((1, 1)))
    )

    p = 0.99 * np.exp(0.3j)
    expected = (Z - p.real) / ((Z - p) * (Z - p.conjugate())) + 1.0 / (Z - 1.0)
    np.testing.assert_allclose(loop.at(Z), expected, rtol=1e-9)
