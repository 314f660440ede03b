"""An oscillator in closed form stands for the replay: y = A exp(-d t) cos(w t) + effect."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.numerics.gains import gain, gain_over, is_accepted, is_worse
from master.diagnosis.numerics.least_squares import Candidate, FreeParameter, fit

T = np.arange(4000) * 1e-3
X = np.cos(8.0 * T) * np.exp(-0.2 * T)
V = np.gradient(X, T)
LAWS = {
    "cubic": X**3,
    "coulomb": np.tanh(V / 0.05),
    "coulomb too": np.tanh(V / 0.0501),
    "quadratic": V * np.abs(V),
    "drift": T,
}
BLOCKS = [slice(2600 + 100 * i, 2600 + 100 * (i + 1)) for i in range(14)]
IN_USE = T < 2.4


def model(*names):
    parameters = (
        FreeParameter("k", 0.5, 0.0, 10.0),
        FreeParameter("c", 0.1),
        *(FreeParameter(n, 0.0, scale=0.1) for n in names),
    )

    def simulate(theta):
        return (
            theta[0] * X + theta[1] * V + sum(a * LAWS[n] for a, n in zip(theta[2:], names, strict=True))
        )[:, None]

    return Candidate(" + ".join(names) or "base", parameters, simulate)


def measured(seed=1, sigma=0.02, **sizes):
    truth = X + 0.2 * V + sum(size * LAWS[name.replace("_", " ")] for name, size in sizes.items())
    return (truth + sigma * np.random.default_rng(seed).standard_normal(len(T)))[:, None]


def test_fit_finds_the_truth_within_its_uncertainty():
    found = fit(model("cubic"), measured(cubic=0.3), IN_USE)

    for name, truth in {"k": 1.0, "c": 0.2, "cubic": 0.3}.items():
        assert abs(found.values[name] - truth) < 4.0 * found.deviations[name]
    assert found.deviations["cubic"] < 0.01
    assert found.at_bound == ()


def test_a_sketch_of_a_fit_has_its_values_and_its_cost_and_costs_less():
    whole = fit(model("cubic"), measured(cubic=0.3), IN_USE)
    sketch = fit(model("cubic"), measured(cubic=0.3), IN_USE, is_sketch=True)

    assert sketch.values == whole.values
    assert sketch.cost == whole.cost
    assert sketch.n_simulations < whole.n_simulations
    assert sketch.deviations == {}


def test_fit_says_which_parameter_lies_at_its_bound():
    y = -X[:, None]

    assert fit(model(), y, IN_USE).at_bound == ("k",)


def test_prior_holds_what_the_data_do_not_know():
    blind = Candidate("blind", (FreeParameter("a", 3.0, spread=1.0),), lambda theta: np.zeros((len(T), 1)))

    assert fit(blind, measured(), IN_USE).values["a"] == pytest.approx(3.0)


def test_diverged_simulation_is_avoided():
    def simulate(theta):
        return np.full((len(T), 1), np.nan) if theta[0] > 2.0 else theta[0] * X[:, None]

    found = fit(Candidate("a", (FreeParameter("a", 0.5, 0.0, 10.0),), simulate), X[:, None], IN_USE)
    assert found.values["a"] == pytest.approx(1.0, abs=1e-6)


def test_second_start_finds_the_other_side():
    def simulate(theta):
        return ((theta[0] ** 2 - 1.0) ** 2 + 0.1 * (1.0 - theta[0]) + 1.05) * X[:, None]

    parameter = (FreeParameter("a", -1.0, -3.0, 3.0),)
    y = X[:, None]
    one = fit(Candidate("one", parameter, simulate), y, IN_USE)
    two = fit(Candidate("two", parameter, simulate, starts=({}, {"a": 1.2})), y, IN_USE)

    assert two.cost < 0.1 * one.cost
    assert two.values["a"] == pytest.approx(1.01, abs=0.01)


def gains(y, before=(), names=LAWS):
    """Gain of each law over the model with those before, by name."""
    start = fit(model(*before), y, IN_USE)
    rivals = {n: fit(model(*before, n), y, IN_USE) for n in names if n not in before}
    return {n: gain_over(start, found, y, BLOCKS, np.ones(1)) for n, found in rivals.items()}


@pytest.mark.parametrize("name", ["cubic", "coulomb", "quadratic"])
def test_missing_law_gains_most(name):
    found = gains(measured(**{name: 0.05}), names=[n for n in LAWS if n != "coulomb too"])
    best = max(found, key=lambda n: found[n].mean)

    assert best == name
    assert is_accepted(found[best], len(found))
    assert all(is_worse(g, found[best]) for n, g in found.items() if n != best)


def test_nothing_is_accepted_where_nothing_is_missing():
    found = [g for seed in range(30) for g in gains(measured(seed)).values()]

    assert sum(is_accepted(g, len(LAWS)) for g in found) <= 1  # 5 % of 30 in the mean


def test_laws_that_cannot_be_told_apart_gain_alike():
    found = gains(measured(coulomb=0.05))

    assert not is_worse(found["coulomb"], found["coulomb too"])
    assert not is_worse(found["coulomb too"], found["coulomb"])


def test_second_law_is_found_beside_the_first_and_no_third():
    y = measured(cubic=0.1, quadratic=0.02)
    second = gains(y, ("cubic",))
    third = gains(y, ("cubic", "quadratic"))

    assert max(second, key=lambda n: second[n].mean) == "quadratic"
    assert is_accepted(second["quadratic"], len(second), is_first=False)
    assert not any(is_accepted(g, len(third), is_first=False) for g in third.values())


@pytest.mark.parametrize(("base", "own", "sign"), [(1.0, 0.0, 1), (0.0, 1.0, -1), (0.0, 0.0, 0)])
def test_a_gain_over_or_to_an_exact_model_is_a_number(base, own, sign):
    found = gain(None, np.full(4, base), np.full(4, own))

    assert np.sign(found.mean) == sign
    assert np.isfinite([found.mean, found.error, found.share, found.z]).all()
