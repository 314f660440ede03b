"""An oscillator in closed form stands for the replay: y = A exp(-d t) cos(w t) + effect."""

from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.fitting import Candidate, Parameter, fit
from master.diagnosis.ranking import cross_validated, family, forward, rank

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
BLOCKS = [slice(2600 + 280 * i, 2600 + 280 * (i + 1)) for i in range(5)]
IN_USE = T < 2.4


def model(*names):
    parameters = (
        Parameter("k", 0.5, 0.0, 10.0),
        Parameter("c", 0.1),
        *(Parameter(n, 0.0, scale=0.1) for n in names),
    )

    def simulate(theta):
        return (
            theta[0] * X + theta[1] * V + sum(a * LAWS[n] for a, n in zip(theta[2:], names, strict=True))
        )[:, None]

    return Candidate(" + ".join(names) or "base", parameters, simulate)


def measured(seed=1, sigma=0.02, **sizes):
    truth = X + 0.2 * V + sum(size * LAWS[name.replace("_", " ")] for name, size in sizes.items())
    return (truth + sigma * np.random.default_rng(seed).standard_normal(len(T)))[:, None]


def base(y):
    return fit(model(), y, IN_USE)


def test_fit_finds_the_truth_within_its_uncertainty():
    found = fit(model("cubic"), measured(cubic=0.3), IN_USE)

    for name, truth in {"k": 1.0, "c": 0.2, "cubic": 0.3}.items():
        assert abs(found.values[name] - truth) < 4.0 * found.deviations[name]
    assert found.deviations["cubic"] < 0.01
    assert found.at_bound == ()


def test_fit_says_which_parameter_lies_at_its_bound():
    y = -X[:, None]

    assert fit(model(), y, IN_USE).at_bound == ("k",)


def test_prior_holds_what_the_data_do_not_know():
    blind = Candidate("blind", (Parameter("a", 3.0, spread=1.0),), lambda theta: np.zeros((len(T), 1)))

    assert fit(blind, measured(), IN_USE).values["a"] == pytest.approx(3.0)


def test_diverged_simulation_is_avoided():
    def simulate(theta):
        return np.full((len(T), 1), np.nan) if theta[0] > 2.0 else theta[0] * X[:, None]

    found = fit(Candidate("a", (Parameter("a", 0.5, 0.0, 10.0),), simulate), X[:, None], IN_USE)
    assert found.values["a"] == pytest.approx(1.0, abs=1e-6)


def test_second_start_finds_the_other_side():
    def simulate(theta):
        return ((theta[0] ** 2 - 1.0) ** 2 + 0.1 * (1.0 - theta[0]) + 1.05) * X[:, None]

    parameter = (Parameter("a", -1.0, -3.0, 3.0),)
    y = X[:, None]
    one = fit(Candidate("one", parameter, simulate), y, IN_USE)
    two = fit(Candidate("two", parameter, simulate, starts=({}, {"a": 1.2})), y, IN_USE)

    assert two.cost < 0.1 * one.cost
    assert two.values["a"] == pytest.approx(1.01, abs=0.01)


@pytest.mark.parametrize("name", ["cubic", "coulomb", "quadratic"])
def test_missing_law_ranks_first(name):
    others = [n for n in LAWS if n != "coulomb too"]
    y = measured(**{name: 0.05})
    step = rank(base(y), [model(n) for n in others], y, IN_USE, BLOCKS)

    assert step.ranked[0].fit.name == name
    assert step.family == (name,)


def test_nothing_is_accepted_where_nothing_is_missing():
    accepted = 0
    for seed in range(30):
        y = measured(seed)
        accepted += bool(rank(base(y), [model(n) for n in LAWS], y, IN_USE, BLOCKS).family)

    assert accepted <= 1


def test_laws_that_cannot_be_told_apart_are_a_family():
    y = measured(coulomb=0.05)
    step = rank(base(y), [model(n) for n in LAWS], y, IN_USE, BLOCKS)

    assert set(step.family) == {"coulomb", "coulomb too"}
    assert family(step.ranked) == step.family


def test_forward_search_finds_two_and_stops():
    y = measured(cubic=0.1, quadratic=0.02)

    def extended(chosen):
        last = chosen[-1].split(" + ") if chosen else []
        return [model(*last, n) for n in LAWS if n not in last and n != "coulomb too"]

    steps = forward(base(y), extended, y, IN_USE, BLOCKS)
    assert set(steps[1].ranked[0].fit.name.split(" + ")) == {"cubic", "quadratic"}
    assert steps[-1].family == ()


def test_cross_validation_gives_the_gain_of_every_block():
    y = measured(cubic=0.1)
    blocks = [slice(800 * i, 800 * (i + 1)) for i in range(5)]
    gain = cross_validated(model(), model("cubic"), y, blocks, guard=50)

    assert gain.is_accepted
    assert len(gain.by_block) == 5
