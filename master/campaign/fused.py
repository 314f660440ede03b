"""The fused form of a campaign's system: compiled while the first runs are made, where that saves time."""

from __future__ import annotations

from master.errors import ConfigError
from master.fuse.runs import Draft, FusedForm, draft_of

from .plan import Plan

FUSED = "fused"
"""What a row says of a run that was made in the fused form; of another run it says why not."""

NOT_YET = "made before the fused form was compiled"
TOO_FEW = "too few runs to compile the fused form for"

# Processor time, as measured on small systems.
_SAVED_A_RUN = 3e-3  # s: new instances, start values, wires
_SAVED_A_STEP = 0.1e-6  # s an FMU and tick
_LOOK = 0.3  # s: to generate the sources
_COMPILE = 0.6  # s an FMU


class Fusing:
    """
    The fused form on its way.

    `form` is the form once it is there, before that and where there is none the reason why not.
    """

    def __init__(self, plan: Plan) -> None:
        self.form: FusedForm | str = NOT_YET
        self._plan = plan
        self._draft: Draft | None = None

    def advance(self) -> None:
        """Do what can be done now without waiting."""
        if self.form != NOT_YET:
            return
        try:
            if self._draft is None:
                self._begin()
            elif self._draft.is_done():
                self._draft.keep()
                self.form = self._draft.form
        except ConfigError as error:
            self.form = "; ".join(problem.partition("\n")[0] for problem in error.problems)
        if self.form != NOT_YET:
            self.close()

    def close(self) -> None:
        """End the compiler if it is at work."""
        if self._draft is not None:
            self._draft.close()

    def _begin(self) -> None:
        plan = self._plan
        structural = [key for key, target in plan.varied.targets.items() if target.is_structural]
        saved = saved_seconds(plan)
        if structural:
            self.form = f"{', '.join(structural)} changes the system itself"
        elif saved < _LOOK:
            self.form = TOO_FEW
        else:
            self._draft = draft_of(plan.base)
            if self._draft.is_compiled:
                self.form = self._draft.form
            elif saved < _COMPILE * len(plan.base.system.instances):
                self.form = TOO_FEW
            else:
                self._draft.begin()


def saved_seconds(plan: Plan) -> float:
    """Processor time that the runs of a campaign take less in the fused form [s]."""
    tune = plan.campaign.tune
    rounds = 1 if tune is None else tune.population * (tune.generations + 1)
    steps = plan.base.grid.n_ticks * len(plan.base.system.instances)
    return plan.sample.n_runs * rounds * (_SAVED_A_RUN + _SAVED_A_STEP * steps)
