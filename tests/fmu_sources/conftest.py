from __future__ import annotations

from types import SimpleNamespace

import pytest

from fmu_sources.framework.model import Model, Slot, no_effect
from fmu_sources.framework.variables import declare, input_, output, parameter, sampled, state


class Oscillator(Model):
    """m y'' = u - slot(k y + c y'), measured by a sensor with a slot, sampled every T by a controller."""

    name = "small"
    description = "Mass on a spring."
    variables = declare(
        parameter("mass", 2.0, "kg", "Mass", above=0.0),
        parameter("k", 800.0, "N/m", "Stiffness"),
        parameter("c", 4.0, "N s/m", "Damping"),
        parameter("T", 1e-3, "s", "Sampling period"),
        input_("u", "N", "Force"),
        state("y", "m", "Position", 0.02),
        state("der_y", "m/s", "Velocity"),
        sampled(state("command", "N", "Command")),
        output("f", "N", "Measured force"),
    )
    slots = (
        Slot("spring", "N", "Force of the spring", {"y": "m", "der_y": "m/s", "load": "N"}),
        Slot("sensor", "N", "Output of the sensor", {"f_act": "N"}),
        Slot("controller", "N", "Command of the controller"),
    )
    sample_time = "T"

    def force(self, x, p, slot):
        return slot("spring", p.k * x.y + p.c * x.der_y, y=x.y, der_y=x.der_y, load=100.0 + 1000.0 * x.y)

    def update(self, t, x, u, p, m, slot=no_effect):
        return {"command": slot("controller", u.u)}

    def derivatives(self, t, x, u, p, m, slot=no_effect):
        return {"y": x.der_y, "der_y": (u.u - self.force(x, p, slot)) / p.mass}

    def outputs(self, t, x, u, p, m, slot=no_effect):
        f = self.force(x, p, slot)
        return {"f": slot("sensor", f, f_act=f)}


@pytest.fixture
def oscillator():
    return Oscillator()


@pytest.fixture
def values_of():
    """Parameters of an effect at typical size, as a record; keywords replace."""

    def make(effect, **given):
        from fmu_sources.effects.framework.effect import Rms

        sizes = {v.name: v.start for v in effect.parameters}
        sizes |= effect.scale(Rms(value=100.0, position=0.01, velocity=0.1, load=100.0, duration=10.0))
        return SimpleNamespace(**(sizes | effect.variants[0] | given))

    return make
