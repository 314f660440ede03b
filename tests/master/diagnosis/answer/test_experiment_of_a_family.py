"""A family is told apart by a recording that shows all its members."""

from __future__ import annotations

import pytest

from master.diagnosis.answer.verdict import experiment


@pytest.mark.parametrize(
    ("family", "words"),
    [
        (
            ("rig.guide: asymmetric_friction", "rig.guide: coulomb and sensor.output: offset"),
            "at rest and at several",
        ),
        (("sensor.output: offset", "sensor.output: drift"), "at rest for longer"),
        (("rig.guide: coulomb", "rig.guide: presliding"), "slow reversals"),
        (("rig.rope: slack", "rig.rope: cubic_stiffness"), "the whole range"),
        (("sensor.output: extra_lag", "sensor.output: gain_error"), "a chirp"),
        (("sensor.output: extra_lag", "rig.guide: coulomb"), "another amplitude"),
        (("rig.guide: learned_position_velocity", "rig.guide: coulomb"), "another amplitude"),
    ],
)
def test_a_family_is_told_apart_by_what_shows_all_its_members(family, words):
    assert words in experiment(family)
