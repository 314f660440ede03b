import math

import numpy as np
import pytest

from master.evaluation.metrics import NAMES, compute_metrics
from master.recording.recorder import Result
from master.system.config import Compare

STEP = 1e-3
TIME = STEP * np.arange(4001)
OMEGA, ZETA, OFFSET = 12.0, 0.02, 0.01
NAMED = Compare(signal="m.s", reproduced="m.r", reference="ideal.s", offset=OFFSET)


def motion(shift=0.0, factor=1.0, zeta=ZETA):
    rate = OMEGA * math.sqrt(1 - zeta * zeta)
    return factor * OFFSET * np.exp(-zeta * OMEGA * TIME) * np.cos(rate * TIME - shift)


def result(**signals):
    names = {"s": "m.s", "r": "m.r", "reference": "ideal.s"}
    table = np.column_stack(list(signals.values()))
    return Result(TIME[: len(table)], tuple(names[n] for n in signals), ("m",) * len(signals), table)


def test_a_motion_equal_to_its_reference_deviates_by_nothing():
    found = compute_metrics(result(s=motion(), r=motion(), reference=motion()), NAMED)

    assert (found["rms_s_des"], found["rms_s_act"]) == (0.0, 0.0)
    assert found["phase_deg"] == pytest.approx(0.0, abs=1e-9)
    assert found["zeta"] == found["zeta_reference"] == pytest.approx(ZETA, abs=1e-9)


def test_frequency_and_growth_are_those_of_the_compared_signal():
    found = compute_metrics(result(s=motion(zeta=-0.03), r=motion(), reference=motion()), NAMED)

    assert found["frequency"] == pytest.approx(OMEGA * math.sqrt(1 - 0.0009) / (2 * math.pi), rel=1e-9)
    assert found["growth_per_cycle"] == pytest.approx(
        math.exp(2 * math.pi * 0.03 / math.sqrt(1 - 0.0009)), rel=1e-8
    )
    assert found["frequency_reference"] == pytest.approx(
        OMEGA * math.sqrt(1 - ZETA**2) / (2 * math.pi), rel=1e-9
    )


def test_rms_is_relative_to_the_offset():
    signals = {"s": motion() + 0.002, "r": motion() - 0.0005, "reference": motion()}
    found = compute_metrics(result(**signals), NAMED)

    assert found["rms_s_des"] == pytest.approx(0.2, rel=1e-12)
    assert found["rms_s_act"] == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize("degrees", [-5.0, -0.3, 2.0])
def test_a_lag_is_a_negative_phase(degrees):
    found = compute_metrics(
        result(s=motion(), r=motion(shift=-math.radians(degrees)), reference=motion()), NAMED
    )

    assert found["phase_deg"] == pytest.approx(degrees, abs=1e-8)


def test_without_a_reference_there_is_nothing_to_compare_with():
    found = compute_metrics(result(s=motion()), Compare(signal="m.s", offset=OFFSET))

    assert found["zeta"] == pytest.approx(ZETA, abs=1e-9)
    assert [n for n in NAMES if found[n] is not None] == ["zeta", "frequency", "growth_per_cycle"]


def test_a_still_signal_has_no_mode_but_a_deviation():
    still = np.zeros(4001)
    found = compute_metrics(result(s=still, r=still, reference=motion()), NAMED)

    assert (found["zeta"], found["growth_per_cycle"]) == (None, None)
    assert found["rms_s_des"] == pytest.approx(math.sqrt(np.mean(motion() ** 2)) / OFFSET, rel=1e-12)


def test_a_run_of_a_few_rows_has_no_metrics():
    short = {k: v[:7] for k, v in {"s": motion(), "r": motion(), "reference": motion()}.items()}

    assert set(compute_metrics(result(**short), NAMED).values()) == {None}


def test_values_that_are_not_finite_become_none():
    endless = np.full(4001, 1e200)
    found = compute_metrics(result(s=endless, r=motion(), reference=motion()), NAMED)

    assert found["rms_s_des"] is None
    assert set(found) == set(NAMES)


@pytest.mark.parametrize("n", [4001, 300])
def test_what_follows_a_value_that_is_not_finite_is_left_out(n):
    whole = {k: v[:n] for k, v in {"s": motion(), "r": motion(shift=0.1), "reference": motion()}.items()}
    broken = whole | {"s": np.concatenate([whole["s"][:-2], [np.nan, 0.0]])}

    assert compute_metrics(result(**broken), NAMED) == compute_metrics(
        result(**{k: v[:-2] for k, v in whole.items()}), NAMED
    )
