"""A model with integer and Boolean inputs and outputs, and without parameters, states and own rules."""

from __future__ import annotations

from dataclasses import replace

from fmu_sources.framework.model import Model, no_effect
from fmu_sources.framework.variables import declare, input_, output


class Typed(Model):
    """count = level + 1, flag = gate and level > 2, size = level / 3."""

    name = "typed"
    description = "Counts, and says so"
    variables = declare(
        replace(input_("level", "1", "Level", start=1), integer=True),
        replace(input_("gate", "1", "Gate", start=1), boolean=True),
        replace(output("count", "1", "Count"), integer=True),
        output("flag", "1", "Flag", boolean=True),
        output("size", "N", "Size"),
    )

    def outputs(self, t, x, u, p, m, slot=no_effect):
        flag = m.where(m.both(u.gate > 0.5, u.level > 2.0), 1.0, 0.0)
        return {"count": u.level + 1.0, "flag": flag, "size": u.level / 3.0}
