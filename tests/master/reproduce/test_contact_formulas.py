"""The formulas that the runs are held against, by the paper's printed numbers and a hand calculation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from master.reproduce.facts.tables import TABLES
from master.reproduce.measures.contact import Loop, process_parameters, response

T = 1e-3


@pytest.mark.parametrize(
    ("case", "frequency", "zeta"),
    [("S1", 0.9746, 0.00486), ("S2", 2.617, 0.00822), ("E1", 0.4346, 0.00306), ("E2", 0.8749, 0.00619)],
)
def test_the_loop_has_its_own_frequency_and_damping(case, frequency, zeta):
    pole = TABLES[case].loop.pole

    assert pole.imag / (2.0 * math.pi) == pytest.approx(frequency, rel=1e-3)
    assert -pole.real / abs(pole) == pytest.approx(zeta, rel=2e-3)


def test_process_parameters_of_table_3_are_those_printed():
    loop = Loop(1000.0, 100.0, 139324.0, 136.25, 37728.5, 97.239)  # exact to the printed digits
    a, b, c, d, e = process_parameters(loop, T, np.array([loop.k_p]))[0]

    assert (c, d, e) == pytest.approx((370.42, -450.02, 131.95), abs=0.02)
    assert (a, b) == pytest.approx((1.994, -0.996), abs=5e-4)


def test_the_response_at_rest_is_the_series_stiffness():
    loop = TABLES["E2"].loop
    Y = process_parameters(loop, T, np.array([loop.k_p]))

    assert response(Y, 0.0, T)[0] == pytest.approx(loop.k_m * loop.k_p / (loop.k_m + loop.k_p))
