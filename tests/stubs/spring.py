"""A model of a user's own, as the text of its file."""

from __future__ import annotations

SPRING = '''\
"""A spring: f = k x."""

from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import declare, input_, output, parameter


class Spring(Model):
    """Hooke's law."""

    name = "spring"
    description = "Linear spring"
    variables = declare(
        parameter("k", 100.0, "N/m", "Stiffness", above=0.0),
        input_("x", "m", "Extension"),
        output("f", "N", "Force"),
    )

    def outputs(self, t, x, u, p, m, slot=None):
        return {"f": p.k * u.x}


MODEL = Spring()
'''
