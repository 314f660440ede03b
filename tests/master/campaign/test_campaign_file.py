"""Campaigns as written: every fault at once, and the tables of values that they mean."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from master.campaign.campaign import Vary
from master.campaign.distributions import drawn
from master.campaign.expression import expression
from master.campaign.plan import make_plan
from master.errors import ConfigError

HEAD = "system: experiment\nvariant: cfdc_fmdc\n"


@pytest.fixture
def plan(tmp_path):
    def make(text):
        path = tmp_path / "campaign.yaml"
        path.write_text(HEAD + text)
        return make_plan(path)

    return make


def column(plan, key):
    [found] = [c.values for c in plan.sample.columns if c.key == key]
    return found


def test_every_fault_of_the_form_is_told_at_once(plan):
    with pytest.raises(ConfigError) as caught:
        plan(
            "variants: x\n"
            "vary:\n"
            "  spacecraft.m_s: {uniform: [900, 400]}\n"
            "  force_sensor.T_f: {normal: [10, 1], uniform: [1, 2]}\n"
            "  contact.k_m: {same_as: contact.k_p, factr: 3.96}\n"
            "design: {method: soboll, size: 1000}\n"
            "keep: {metrics: [zetta], measures: {a: {rms: contact.x, band: 1.0, energy: contact.x}}}\n"
        )
    wheres = [p.where.partition(": ")[2] for p in caught.value.problems]

    assert set(wheres) == {
        "variants",
        "vary.spacecraft.m_s",
        "vary.force_sensor.T_f",
        "vary.contact.k_m.factr",
        "design.method",
        "keep.metrics[0]",
        "keep.measures.a",
    }
    [key] = [p for p in caught.value.problems if p.where.endswith("factr")]
    assert key.expected.startswith("'factor'")


def test_every_fault_of_names_is_told_at_once(plan):
    with pytest.raises(ConfigError) as caught:
        plan(
            "vary:\n"
            "  spacecraft.m_x: {uniform: [400, 900]}\n"
            "  connections[contact.s_at].delay: {values: [0, 1]}\n"
            "  seeed: {integers: [1, 2]}\n"
            "design: {method: random, size: 4}\n"
            "keep: {signals: {a.b: 2}, measures: {x: {rms: spacecraft.s_dess}}}\n"
        )
    lines = "\n".join(caught.value.problems)

    assert "vary.spacecraft.m_x: no such variable of spacecraft" in lines
    assert "expected a number below 9, or a target: 'contact.s_act'" in lines
    assert "vary.seeed" in lines
    assert "keep.signals.a.b: no such FMU" in lines
    assert "'s_des' (of s_des, v_des)" in lines


@pytest.mark.parametrize(
    ("vary", "said"),
    [
        ("contact.k_p: {uniform: [-5, 5]}", "vary.contact.k_p: contact.k_p: value not allowed"),
        ("contact.m_e: {uniform: [1, 2], unit: s}", "another quantity, got s, expected one as kg"),
        ("contact.m_e: {uniform: [1, 2], unit: kgg}", "not a unit"),
        ("contact.k_p: {expression: 'contact.k_q * 2'}", "no such variable of contact"),
        ("contact.k_p: {expression: '__import__(1)'}", "not arithmetic"),
        ("contact.k_p: {same_as: force_sensor.T_f}", "another quantity, got s -> N/m"),
        ("contact.k_p: {normal: [10, 1], bounds: [100, 200]}", "bounds leave nothing"),
        ("contact.k_p: {same_as: contact.k_m}\n  contact.k_m: {same_as: contact.k_p}", "needs itself"),
        ("connections[contact.s_act].delay: {values: [0, -2]}", "connections[6].delay: too small, got -2"),
        ("method: {values: [smit]}", "no such method, got 'smit', expected 'smith'"),
        ("fmus.contact.source: {values: [dockin_contact]}", "expected 'docking_contact'"),
    ],
)
def test_a_value_that_does_not_fit_is_told_before_the_first_run(plan, vary, said):
    with pytest.raises(ConfigError) as caught:
        plan(f"vary:\n  spacecraft.m_s: {{uniform: [1, 2]}}\n  {vary}\ndesign: {{method: random, size: 8}}\n")

    assert said in "\n".join(caught.value.problems)


def test_a_grid_has_all_combinations_and_the_last_value_varies_fastest(plan):
    found = plan("vary: {contact.k_p: {linspace: [1, 3, 3]}, compensator.dpdc: {values: [false, true]}}\n")

    assert found.sample.n_runs == 6
    assert column(found, "contact.k_p").tolist() == [1, 1, 2, 2, 3, 3]
    assert column(found, "compensator.dpdc").tolist() == [False, True] * 3


def test_units_links_and_expressions_follow_the_drawn_values(plan):
    found = plan(
        "vary:\n"
        "  force_sensor.T_f: {uniform: [5, 15], unit: ms}\n"
        "  contact.k_m: {expression: '2 * contact.k_p + 1000 * contact.m_e'}\n"
        "  contact.k_p: {uniform: [30000, 40000]}\n"
        "  compensator.T_f_hat: {same_as: force_sensor.T_f, factor: 0.5, offset: 0.001}\n"
        "design: {method: latin_hypercube, size: 50, seed: 3}\n"
    )
    T_f = column(found, "force_sensor.T_f")

    assert (T_f.min() >= 0.005, T_f.max() <= 0.015) == (True, True)
    assert sorted(np.floor((T_f - 0.005) / 0.0002).astype(int)) == list(range(50))  # one in each of 50 layers
    assert np.array_equal(column(found, "compensator.T_f_hat"), 0.5 * T_f + 0.001)
    assert np.array_equal(column(found, "contact.k_m"), 2 * column(found, "contact.k_p") + 1000 * 100.0)


def test_correlated_values_have_the_rank_correlation_of_the_copula(plan):
    found = plan(
        "vary: {contact.k_p: {lognormal: [30000, 0.3]}, contact.c_p: {uniform: [50, 100]}}\n"
        "correlations: [{of: [contact.k_p, contact.c_p], value: 0.7}]\n"
        "design: {method: random, size: 20000}\n"
    )
    rho = stats.spearmanr(column(found, "contact.k_p"), column(found, "contact.c_p")).statistic

    assert rho == pytest.approx(6 / np.pi * np.arcsin(0.35), abs=0.02)  # exact for a Gaussian copula


@pytest.mark.parametrize(
    ("vary", "law"),
    [
        ({"uniform": (2.0, 5.0)}, stats.uniform(2.0, 3.0)),
        ({"normal": (3.0, 0.5)}, stats.norm(3.0, 0.5)),
        ({"lognormal": (2.0, 0.3)}, stats.lognorm(0.3, scale=2.0)),
        ({"triangular": (1.0, 2.0, 5.0)}, stats.triang(0.25, 1.0, 4.0)),
        ({"normal": (3.0, 0.5), "bounds": (2.8, 3.6)}, stats.truncnorm(-0.4, 1.2, 3.0, 0.5)),
    ],
)
def test_a_distribution_has_the_quantiles_of_scipy(vary, law):
    u = np.linspace(0.001, 0.999, 200)

    assert np.allclose(drawn(Vary(**vary), u), law.ppf(u), rtol=1e-9, atol=1e-12)


def test_choices_have_their_weights(plan):
    found = plan(
        "vary: {compensator.dpdc: {choice: [true, false], weights: [3, 1]}}\n"
        "design: {method: sobol, size: 1024}\n"
    )

    assert np.mean(column(found, "compensator.dpdc")) == pytest.approx(0.75, abs=0.002)


def test_expressions_are_arithmetic_with_signals():
    found = expression("-a.b ** 2 + max(c.d, 3) / sqrt(16) + pi")

    assert found.names == ("a.b", "c.d")
    assert found.value({"a.b": 3.0, "c.d": 8.0}) == pytest.approx(-9.0 + 2.0 + np.pi)
    with pytest.raises(ValueError, match="no value"):
        expression("1 / a.b").value({"a.b": 0.0})
