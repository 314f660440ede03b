"""Where methods that are right on a rig as believed fail: shipped cells, one seed."""

from __future__ import annotations

import pytest

from master.comparison.cells import Cell, read_cells
from master.comparison.compare import Score, Task, scores
from master.comparison.methods import all_methods
from master.installation import CONFIG_FOLDER

OURS = "robust"


def judged(config: str, cell: str, *methods: str) -> dict[str, Score]:
    """Map methods to their scores in a cell that is shipped."""
    path = CONFIG_FOLDER / f"{config}.yaml"
    known = all_methods()
    work = [Task(path, cell, read_cells()[cell], known[name], (1,)) for name in methods]
    return dict(zip(methods, scores(work), strict=True))


@pytest.mark.slow
def test_a_fixed_inverse_and_a_predictor_diverge_where_the_plant_is_a_fifth_slower():
    found = judged("high_frequency", "plant lag x1.2", "inverse3", "smith", OURS)

    assert (found["inverse3"].status, found["smith"].status) == ("diverged", "diverged")
    assert found[OURS].s_des < 0.15
    assert found[OURS].s_act < 1.2


@pytest.mark.slow
def test_preset_l_diverges_with_a_noisy_encoder_and_preset_f_does_not():
    found = judged("experiment_1000kg", "s_act noise 20 um", "paper_L", "paper_F", OURS)

    assert found["paper_L"].status == "diverged"
    assert found["paper_F"].status == "completed"
    assert found[OURS].s_des < 0.4


@pytest.mark.slow
@pytest.mark.parametrize("config", ["high_frequency", "experiment_1000kg"])
def test_a_stiffness_that_varies_is_not_taken_for_a_latency(config):
    """A rope that varies by 12 % at 1 Hz, with the bounds of one that varies by 20 %."""
    varies = {f"{part}.k_p_amplitude": "0.12 contact.k_p" for part in ("contact", "ideal")}
    cell = Cell(set=dict(varies), stop_time=6.0)
    [found] = scores([Task(CONFIG_FOLDER / f"{config}.yaml", "varies", cell, all_methods()[OURS], (1,))])

    assert found.s_des < 0.1
    assert found.s_act < 0.5


@pytest.mark.long
def test_no_other_method_survives_a_sensor_that_is_slower_than_believed():
    found = judged("experiment_1000kg", "T_f 13 ms, believed 10", *all_methods())
    ours = found.pop(OURS)

    assert len(found) >= 13
    assert all(score.status == "diverged" or score.s_des > 15.0 for score in found.values())
    assert ours.s_des < 3.0


@pytest.mark.long
@pytest.mark.parametrize("config", ["low_frequency", "high_frequency", "experiment", "experiment_1000kg"])
@pytest.mark.parametrize("cell", ["c believed x0.7", "c believed x1.3"])
def test_in_doubt_a_damping_that_is_believed_wrong_costs_nothing(config, cell):
    found = judged(config, cell, OURS)[OURS]

    assert found.s_des < 0.2
    assert found.s_act < 0.5
