from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from fmu_sources.compensator.difference import process_parameters
from fmu_sources.compensator.identifiers import rls
from fmu_sources.compensator.identifiers.framework import recursion
from fmu_sources.compensator.identifiers.framework.catalogue import IdentifierChoice as Identifier
from fmu_sources.compensator.tuning import F, L, Preset, low_pass, prefilter_share
from fmu_sources.framework.arithmetic import PYTHON
from tests.fmu_sources.compensator.made import OFF, T, make, parameters, step

ROWS, COLUMNS = np.triu_indices(5)


def packed(P):
    return tuple(P[ROWS, COLUMNS])


def measurements(n=40, seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, 5)), rng.normal(size=n)


def test_the_covariance_is_packed_row_by_row():
    assert recursion.diagonal(2.0, 3.0) == packed(np.diag([2.0, 2.0, 3.0, 3.0, 3.0]))


def test_the_kalman_filter_equals_its_matrix_form():
    Q, R = np.diag([1e-3, 1e-3, 2e-2, 2e-2, 2e-2]), 0.3
    Y, P = (0.0,) * 5, recursion.diagonal(2.0, 3.0)
    y, p = np.zeros(5), np.diag([2.0, 2.0, 3.0, 3.0, 3.0])
    for H, z in zip(*measurements(), strict=True):
        Y, P = recursion.corrected(Y, recursion.predicted(P, 1e-3, 2e-2), tuple(H), z, R, PYTHON)
        p = p + Q
        K = p @ H / (H @ p @ H + R)
        y = y + K * (z - H @ y)
        p = (np.eye(5) - np.outer(K, H)) @ p

    assert pytest.approx(y, rel=1e-10) == Y
    assert pytest.approx(packed(p), rel=1e-9, abs=1e-12) == P


def test_least_squares_solve_the_weighted_normal_equations():
    H, z = measurements()
    forgetting_factor, P0 = 0.9, 1e2
    Y, P = (0.0,) * 5, recursion.diagonal(P0, P0)
    for row, value in zip(H, z, strict=True):
        P = recursion.inflated(P, rls.forgetting(P, forgetting_factor, PYTHON))
        Y, P = recursion.corrected(Y, P, tuple(row), value, rls.R, PYTHON)
    w = forgetting_factor ** np.arange(len(z) - 1, -1, -1)
    normal = (H.T * w) @ H + forgetting_factor ** len(z) / P0 * np.eye(5)

    assert pytest.approx(np.linalg.solve(normal, (H.T * w) @ z), rel=1e-9) == Y


def test_least_squares_do_not_wind_up_without_bound():
    P = recursion.diagonal(1.0, 1.0)
    for _ in range(20_000):
        P = recursion.inflated(P, rls.forgetting(P, 0.9, PYTHON))

    assert sum(P[i] for i in recursion.DIAGONAL) <= rls.LARGEST_TRACE / 0.9


def test_the_prefilter_is_two_low_passes():
    share = prefilter_share(5.0, T, PYTHON)
    u = np.sin(0.05 * np.arange(300))
    stage, y, rows = 0.0, 0.0, []
    for value in u:
        stage, y = low_pass(stage, y, value, share)
        rows.append(y)
    pole = np.exp(-2 * np.pi * 5.0 * T)
    once = lfilter([1 - pole], [1, -pole], u)

    assert rows == pytest.approx(lfilter([1 - pole], [1, -pole], once), rel=1e-12)
    assert prefilter_share(0.0, T, PYTHON) == 1.0


def excited(compensator, n=2000):
    """Feed the exact difference equation of S1 under a rich motion."""
    a, b, c, d, e = process_parameters(parameters("S1"), 1.0)
    t = T * np.arange(n)
    s = 0.005 * (np.sin(2 * np.pi * t) + np.sin(40 * t) + np.sin(300 * t * t))
    f = lfilter([-c, -d, -e], [1, -a, -b], s)
    for k in range(n):
        step(compensator, k, s_act=s[k], s_des=s[k], f_mea=f[k])
    return (a, b, c, d, e)


@pytest.mark.parametrize("identifier", [Identifier.kalman, Identifier.rls])
def test_rich_motion_without_noise_identifies_the_truth(identifier):
    tuning = {"preset": Preset.custom, "P0_ab": 1.0, "P0_cde": 1e8, "R": 1e-8, "forgetting_factor": 1.0}
    compensator = make(**OFF, identifier=identifier, **tuning)
    truth = excited(compensator)

    assert [compensator[n] for n in "abcde"] == pytest.approx(truth, rel=2e-4)
    assert compensator["attributes_valid"]


def test_the_prior_is_the_truth_with_a_smaller_gain():
    a, b, c, d, e = process_parameters(parameters("S1"), 1.0)
    compensator = make(identifier=Identifier.kalman)

    assert [compensator[n] for n in "abcde"] == pytest.approx((a, b, 0.95 * c, 0.95 * d, 0.95 * e))


def test_fixed_parameters_stay_as_they_are():
    compensator = make(**OFF, identifier=Identifier.fixed)
    truth = excited(compensator, 50)

    assert tuple(compensator[n] for n in "abcde") == truth
    assert compensator["m_e_id"] == pytest.approx(80.0, rel=1e-6)


@pytest.mark.parametrize(("preset", "tuning"), [(Preset.L, L), (Preset.F, F)])
def test_a_preset_equals_the_same_custom_tuning(preset, tuning):
    named, custom = make(**OFF, preset=preset), make(**OFF, preset=Preset.custom, **tuning._asdict())
    for compensator in (named, custom):
        excited(compensator, 200)

    assert [named[n] for n in "abcde"] == [custom[n] for n in "abcde"]
