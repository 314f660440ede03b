"""Content of the page of a reproduction that nobody had to compute."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from master.pages.chart import Chart, Curve
from master.reproduce.claims.claim import CONDITION, HOLDS, Claim, Row
from master.reproduce.facts.orders import Ordered
from master.reproduce.page import Content

CHART = Chart("</script>", "time [s]", "force [N]", [Curve("f", np.arange(3.0), np.arange(3.0))])
CLAIM = Claim("stable", "Sec. I", "It is <stable>", "because", ())
ROWS = [
    Row(
        *("stable.one", "Sec. I", "It is <stable> (first case)", "zeta > 0", "a formula"),
        *(0.25, 10, "worst of 10 seeds", HOLDS, "because"),
    ),
    Row(
        *("stable.two", "Sec. I", "It is <stable> (second case)", "zeta > 0", "a formula"),
        *(None, 10, "no noise", CONDITION, "maybe"),
    ),
]
ORDERS = [Ordered("the order", 20, ("a.x -> b.u",), 2.0, -0.1, 0.005, 0.0049)]


def made_up_content(charts: Mapping[str, Sequence[Chart]]) -> Content:
    """A claim with two rows, an order, and charts by figure."""
    return Content(charts, [(CLAIM, ROWS)], ORDERS)
