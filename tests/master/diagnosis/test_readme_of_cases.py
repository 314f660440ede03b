"""What a stranger copies from configs/measured/README.md works as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from fmu_sources.export.own_model import load_model
from fmu_sources.framework.instance import Instance
from master.diagnosis.case.case import load_case
from master.diagnosis.data.measured_signals import opened

README = Path(__file__).parents[3] / "configs" / "measured" / "README.md"
N = 12_000


def block(language):
    return re.search(f"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)[1]


def test_the_case_is_one(tmp_path):
    t = np.arange(N) * 1e-3
    table = np.column_stack([1e3 * t, 40.0 * np.sin(t), np.cos(t)])
    names = ["t", "pos", "load cell"]
    np.savetxt(tmp_path / "run_1.csv", table, delimiter=",", header=",".join(names), comments="")
    np.savez(tmp_path / "all.npz", second=table, columns=np.array(names))
    (tmp_path / "case.yaml").write_text(block("yaml"))

    system, recordings = opened(load_case(tmp_path / "case.yaml"))

    assert system.parts[0].name == "axis"
    assert {name: len(r) for name, r in recordings.items()} == {"run_1": N, "run_2": 10_000}
    assert recordings["run_1"]["der_q"][N // 2] == pytest.approx(0.04 * np.cos(6.0), abs=1e-6)


def test_the_model_is_one(tmp_path):
    (tmp_path / "cart.py").write_text(block("python"))
    cart = Instance(load_model(tmp_path / "cart.py"))
    cart["q"] = 0.01
    cart.initialise()
    for k in range(200):
        cart.step(k * 1e-3, 1e-3)

    w, decay = np.sqrt(300.0 / 2.0 - 1.25**2), 1.25  # of 2 q'' + 5 q' + 300 q = 0
    expected = 0.01 * np.exp(-decay * 0.2) * (np.cos(w * 0.2) + decay / w * np.sin(w * 0.2))
    assert cart["q"] == pytest.approx(expected, rel=1e-6)
