from __future__ import annotations

import pytest

from fmu_sources.composed.composition import with_effect
from fmu_sources.composed.names import composed, is_composed
from fmu_sources.effects.catalogue import effect


@pytest.mark.parametrize("name", ["coulomb", "learned_position_velocity", "end_stop"])
def test_name_makes_the_model_that_it_names(oscillator, name):
    model = with_effect(with_effect(oscillator, "spring", effect(name)), "sensor", effect("extra_lag"))

    again = composed(model.name, {"small": oscillator}.__getitem__)
    assert is_composed(model.name)
    assert again.name == model.name
    assert again.all_variables == model.all_variables


def test_unknown_part_names_the_slots(oscillator):
    with pytest.raises(ValueError, match=r"got 'spring_magic', expected <slot>_<effect>, slots \['spring'"):
        composed("small__spring_magic", lambda _: oscillator)
