"""The fused form of a campaign's system: compiled while the first runs are made, where that saves time."""

from __future__ import annotations

from master.errors import ConfigError
from master.fmi.values import named_by
from master.fuse.runs import Draft, FusedForm, draft_of
from master.text.signal_name import SignalName

from .plan import Plan

FUSED = "fused"
"""What a row says of a run that was made in the fused form; of another run it says why not."""

NOT_YET = "made while the fused form was prepared"
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
        self._plan = plan
        self._saved = saved_seconds(plan)
        self._draft: Draft | None = None
        self.form: FusedForm | str = self._why_never() or NOT_YET

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
            self.form = "; ".join(map(_in_one_line, error.problems))
        if self.form != NOT_YET:
            self.close()

    def close(self) -> None:
        """End the compiler if it is at work."""
        if self._draft is not None:
            self._draft.close()

    def _why_never(self) -> str:
        """Say why there will be no form, as far as that is known without generating its sources."""
        structural = [key for key, target in self._plan.varied.targets.items() if target.is_structural]
        if structural:
            return f"{', '.join(structural)} changes the system itself"
        return TOO_FEW if self._saved < _LOOK else ""

    def _begin(self) -> None:
        self._draft = draft_of(self._plan.base)
        form = self._draft.form
        form.require(varied_starts(self._plan))
        if self._draft.is_compiled:
            self.form = form
        elif self._saved < _COMPILE * len(self._plan.base.system.instances):
            self.form = TOO_FEW
        else:
            self._draft.begin()


def _in_one_line(problem: str) -> str:
    """Return the first line of a problem, and the next one where the first ends with a colon."""
    first, *others = problem.splitlines()
    return f"{first} {others[0].strip()}" if first.endswith(":") and others else first


def varied_starts(plan: Plan) -> set[str]:
    """Variables of FMUs, and elements of arrays, whose start values differ from run to run."""
    instances = plan.base.system.instances
    names = [SignalName(signal) for target in plan.varied.targets.values() for signal in target.signals]
    return {
        f"{name.instance}.{variable.name}"
        for name in names
        for variable in named_by(instances[name.instance].description, name.variable)
    }


def saved_seconds(plan: Plan) -> float:
    """Processor time that the runs of a campaign take less in the fused form [s]."""
    tune = plan.campaign.tune
    rounds = 1 if tune is None else tune.population * (tune.generations + 1)
    steps = plan.base.grid.n_ticks * len(plan.base.system.instances)
    return plan.sample.n_runs * rounds * (_SAVED_A_RUN + _SAVED_A_STEP * steps)
