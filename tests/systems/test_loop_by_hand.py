from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from fmu_sources.compensator.difference import DifferenceMethod
from fmu_sources.compensator.identifiers.framework.catalogue import IdentifierChoice
from fmu_sources.compensator.tuning import Preset
from tests.costs import long_for
from tests.systems.closed_loop_matrix import damping, loop_matrix, real_matrix
from tests.systems.loop_by_hand import CASES, compensation, oscillation, rms, run

pytestmark = pytest.mark.slow

STOP = {"S1": 4.0, "S2": 2.5, "E1": 6.0, "E2": 4.0}
EXACT, F, L = {"identifier": IdentifierChoice["fixed"]}, {"preset": Preset.F}, {"preset": Preset.L}
TIME_VARYING = {"preset": Preset.custom, "prefilter_frequency": 0.0, "R": 1e-3}


@cache
def motion(case, parts, tuning):
    return run(case, STOP[case], compensation(case, *parts, **dict(tuning)))


def fitted(case, *parts, column=0, **tuning):
    s = motion(case, parts, tuple(tuning.items()))
    return oscillation(s[:, column], CASES[case].frequency)


def deviation(case, *parts, column=0, **tuning):
    s = motion(case, parts, tuple(tuning.items()))
    return rms(s[:, column], s[:, 2], CASES[case].s0)


def oracle(case, parts):
    c = CASES[case]
    lead = (math.radians(c.lag), c.frequency) if "dpdc" in parts else None
    switches = {name: name in parts for name in ("cfdc", "fmdc")}
    return damping(loop_matrix(c.m_s, c.contact, c.T_f, **switches, dpdc=lead), c.frequency)


@pytest.mark.parametrize("case", CASES)
def test_the_real_docking_oscillates_as_its_matrix_says(case):
    found = fitted(case, "cfdc", "fmdc", column=2, **EXACT)
    exact = damping(real_matrix(CASES[case].m_s, CASES[case].contact), CASES[case].frequency)

    assert exact == pytest.approx(CASES[case].zeta, abs=1e-5)
    assert found.zeta == pytest.approx(exact, abs=1e-4)


@pytest.mark.long
@pytest.mark.parametrize(("case", "growth"), [("S1", 1.93), ("S2", 5.01), ("E1", 1.45), ("E2", 2.11)])
def test_the_loop_diverges_without_compensation(case, growth):
    assert fitted(case).growth == pytest.approx(growth, rel=5e-3)


@pytest.mark.parametrize("parts", [(), ("dpdc",), ("cfdc", "fmdc"), ("cfdc", "fmdc", "dpdc")])
@pytest.mark.parametrize("case", long_for(["E1", "S2"], CASES))
def test_damping_equals_the_eigenvalue_of_the_independent_matrix(case, parts):
    has_lag = CASES[case].T_f > 0
    parts = tuple(part for part in parts if has_lag or part != "fmdc")

    assert fitted(case, *parts, **EXACT).zeta == pytest.approx(oracle(case, parts), abs=5e-4)


@pytest.mark.parametrize(("case", "largest"), [("S1", 0.0025), ("S2", 0.0062), ("E1", 0.0015), ("E2", 0.003)])
def test_exact_parameters_follow_the_real_docking(case, largest):
    assert deviation(case, "cfdc", "fmdc", **EXACT) < largest


@pytest.mark.long
@pytest.mark.parametrize(("tuning", "largest"), [(F, 0.01), (L, 0.03)], ids=["F", "L"])
@pytest.mark.parametrize("case", CASES)
def test_the_presets_stop_the_divergence(case, tuning, largest):
    zeta = fitted(case, "cfdc", "fmdc", **tuning).zeta

    assert abs(zeta - CASES[case].zeta) < 5e-4
    assert deviation(case, "cfdc", "fmdc", **tuning) < largest


@pytest.mark.long
@pytest.mark.parametrize(("tuning", "largest"), [(EXACT, 1.0), (F, 1.0), (L, 2.0)], ids=["exact", "F", "L"])
@pytest.mark.parametrize("case", CASES)
def test_with_all_parts_the_simulator_coincides_with_the_real_docking(case, tuning, largest):
    parts = ("cfdc", "fmdc", "dpdc")
    actual, real = (fitted(case, *parts, column=i, **tuning) for i in (1, 2))
    phase = np.angle(actual.amplitude / real.amplitude, deg=True)

    assert deviation(case, *parts, column=1, **tuning) < 0.03
    assert abs(phase) < largest


@pytest.mark.long
@pytest.mark.parametrize(("part", "least"), [("fmdc", 1.0), ("cfdc", 1.04)])
@pytest.mark.parametrize("case", ["E1", "E2"])
def test_one_part_alone_only_slows_the_divergence(case, part, least):
    assert least < fitted(case, part, **EXACT).growth < fitted(case).growth


@pytest.mark.long
@pytest.mark.parametrize("method", [DifferenceMethod.forward, DifferenceMethod.bilinear])
@pytest.mark.parametrize("case", ["S1", "S2"])
def test_every_difference_method_gives_the_same_fundamental(case, method):
    other = fitted(case, "cfdc", **EXACT, difference_method=method)

    assert other.zeta == pytest.approx(fitted(case, "cfdc", **EXACT).zeta, abs=2e-4)


@pytest.mark.long
def test_the_kalman_filter_follows_a_stiffness_that_varies():
    tuning = TIME_VARYING | {"P0_ab": 1e-10, "P0_cde": 1.0, "Q_cde": 1.0}
    s = run("S2", 6.0, compensation("S2", "cfdc", **tuning), amplitude=8e4)

    assert rms(s[:, 0], s[:, 2], CASES["S2"].s0) < 0.03


@pytest.mark.long
@pytest.mark.parametrize("forgetting_factor", [0.9, 0.98, 0.995, 1.0])
def test_least_squares_do_not_follow_a_stiffness_that_varies(forgetting_factor):
    tuning = TIME_VARYING | {"P0_ab": 1e4, "P0_cde": 1e4, "identifier": IdentifierChoice["rls"]}
    tuning["forgetting_factor"] = forgetting_factor
    s = run("S2", 6.0, compensation("S2", "cfdc", **tuning), amplitude=8e4)

    assert rms(s[:, 0], s[:, 2], CASES["S2"].s0) > 0.08
