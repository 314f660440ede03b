from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter, lfilter_zi

from fmu_sources.compensator.contact_force import correction
from fmu_sources.compensator.difference import process_parameters
from fmu_sources.compensator.identifiers.framework.catalogue import IdentifierChoice as Identifier
from fmu_sources.compensator.phase_lead import GainConvention
from tests.fmu_sources.compensator.made import OFF, T, make, parameters, step

LAG = math.radians(33.2)
S = 0.01 * np.sin(0.02 * np.arange(1, 200)) + 0.004


def test_the_force_lead_is_the_backward_difference():
    compensator = make(**OFF | {"fmdc": True}, T_f_hat=0.01, f_mea=5.0)
    step(compensator, 0, f_mea=5.0)
    step(compensator, 1, f_mea=6.0)

    assert compensator["f_lead"] == pytest.approx(6.0 + 10.0 * 1.0)


def test_the_filtered_force_lead_equals_its_difference_equation():
    compensator = make(**OFF | {"fmdc": True}, T_f_hat=0.01, fmdc_filter=0.002)
    f = 100.0 * np.sin(0.1 * np.arange(1, 100))
    rows = []
    for k, value in enumerate(f):
        step(compensator, k, f_mea=value)
        rows.append(compensator["f_lead"])
    num, den = np.array([T + 0.01, -0.01]), np.array([T + 0.002, -0.002])

    assert rows == pytest.approx(lfilter(num, den, f), rel=1e-10)


def test_the_force_lead_undoes_a_lag_on_a_ramp():
    compensator = make(**OFF | {"fmdc": True}, T_f_hat=0.01)
    for k in range(50):
        step(compensator, k, f_mea=1000.0 * (k * T - 0.01))

    assert compensator["f_lead"] == pytest.approx(1000.0 * 49 * T, rel=1e-9)


def test_the_contact_force_correction_by_hand():
    Y = (0.5, -0.25, 100.0, -50.0, 20.0)

    assert correction(Y, (4.0, 8.0), (0.01, 0.02, 0.03)) == pytest.approx(2.0 - 2.0 - (1.0 - 1.0 + 0.6))


def test_the_contact_force_correction_equals_a_digital_filter_from_rest():
    compensator = make(**OFF | {"cfdc": True}, identifier=Identifier.fixed)
    a, b, c, d, e = process_parameters(parameters("S1"), 1.0)
    rows = []
    for k, ds in enumerate(S - 0.004):
        step(compensator, k, s_des=ds, s_act=0.0, f_mea=7.0)
        rows.append(compensator["df"])

        assert compensator["f_des"] == 7.0 + compensator["df"]
    assert rows == pytest.approx(lfilter([-c, -d, -e], [1, -a, -b], S - 0.004), rel=1e-8)


@pytest.mark.parametrize("gain", [1.0, 1.13])
@pytest.mark.parametrize("convention", GainConvention)
def test_the_phase_lead_equals_the_bilinear_filter_of_scipy(convention, gain):
    lead = {
        "dpdc_phase": LAG,
        "dpdc_frequency": 2.617,
        "dpdc_gain": gain,
        "gain_convention": convention,
    }
    compensator = make(**OFF | {"dpdc": True}, s_des=0.004, **lead)
    alpha = (1 + math.sin(LAG)) / (1 - math.sin(LAG))
    T_lead = 1 / (2 * math.pi * 2.617 * math.sqrt(alpha))
    K = gain / math.sqrt(alpha) if convention == GainConvention.paper else gain
    num, den = bilinear([K * alpha * T_lead, K], [T_lead, 1.0], 1 / T)
    expected, _ = lfilter(num, den, S, zi=lfilter_zi(num, den) * 0.004)
    start, rows = compensator["s_cmd"], []
    for k, s in enumerate(S):
        step(compensator, k, s_des=s)
        rows.append(compensator["s_cmd"])

    assert start == pytest.approx(K * 0.004, rel=1e-14)
    assert rows == pytest.approx(expected, rel=1e-9)
    assert (alpha, T_lead) == pytest.approx((3.421, 0.0329), rel=2e-3)


@pytest.mark.parametrize(
    ("values", "gain"),
    [
        ({"gain_convention": GainConvention.paper}, 1.0),
        ({"gain_convention": GainConvention.paper, "dpdc_gain": 1.13}, 1.13),
        ({"gain_convention": GainConvention.unit_dc}, math.sqrt(3.421)),
    ],
)
def test_the_phase_lead_gives_its_angle_and_gain_at_its_frequency(values, gain):
    frequency = 2.617
    lead = {"dpdc_phase": LAG, "dpdc_frequency": frequency}
    compensator = make(**OFF | {"dpdc": True}, **lead | values)
    t = T * np.arange(4000)
    rows = []
    for k, s in enumerate(np.sin(2 * np.pi * frequency * t)):
        step(compensator, k, s_des=s)
        rows.append(compensator["s_cmd"])
    late = t > 1.0
    waves = np.c_[np.sin(2 * np.pi * frequency * t), np.cos(2 * np.pi * frequency * t)][late]
    sin, cos = np.linalg.lstsq(waves, np.array(rows)[late], rcond=None)[0]

    assert math.atan2(cos, sin) == pytest.approx(LAG, abs=1e-4)
    assert math.hypot(sin, cos) == pytest.approx(gain, rel=1e-3)
