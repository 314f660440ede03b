"""
Runs on a Dask cluster: FMUs and recordings travel once, by their digests; runs are watched there as here.

A worker of the cluster hands its runs to a process next to it (`station`), so that an FMU that crashes or
hangs does not take the worker along; between the two goes what only the ends understand (`relay`).
"""

from __future__ import annotations

import hashlib
import importlib
import pickle
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from master.errors import ConfigError, Problem
from master.installation import CAMPAIGN, cache_folder, require
from master.recording.whole_file import write_whole

from .crew import Order
from .plan import Plan
from .relay import run_batch
from .stepper import Row

_BATCH_SECONDS = 1.0
_MOST_IN_BATCH = 500
_BATCHES_A_CORE = 2
_LOOK_SECONDS = 0.2


@dataclass(frozen=True)
class Bundle:
    """A plan and the files that it needs, content by SHA-256; `paths` names them as the plan does."""

    plan: bytes
    files: Mapping[str, bytes]
    paths: Mapping[str, str]

    def unpacked(self) -> Plan:
        """Put the files into the cache of this machine, and return the plan with their places here."""
        here: dict[Path, Path] = {}
        for path, digest in self.paths.items():
            place = cache_folder() / "campaigns" / f"{digest}{Path(path).suffix}"
            if not place.is_file():
                write_whole(place, self.files[digest])
            here[Path(path)] = place
        plan: Plan = pickle.loads(self.plan)
        return _moved(plan, here)


def bundle(plan: Plan) -> Bundle:
    """Pack a plan with its files."""
    instances = plan.base.system.instances.values()
    paths = {i.description.path for i in instances} | set(plan.base.inputs.files.values())
    content = {str(path): path.read_bytes() for path in paths if path.is_file()}
    digests = {path: hashlib.sha256(data).hexdigest() for path, data in content.items()}
    files = {digests[path]: data for path, data in content.items()}
    return Bundle(pickle.dumps(plan), files, digests)


def _moved(plan: Plan, here: Mapping[Path, Path]) -> Plan:
    """Let the descriptions of a plan name the files of this machine."""
    base = plan.base
    instances = {}
    for name, instance in base.system.instances.items():
        described = instance.description
        place = here.get(described.path, described.path)
        instances[name] = replace(instance, description=replace(described, path=place))
    moved = replace(base, system=replace(base.system, instances=instances))
    return replace(plan, varied=replace(plan.varied, base=moved))


class Cluster:
    """
    A Dask cluster that makes the runs of a plan; `cores` is the number of its threads.

    Raises:
        ConfigError: If Dask is missing, no scheduler answers, or runs need files that do not travel.
    """

    def __init__(self, plan: Plan, address: str) -> None:
        require(CAMPAIGN, "sweep --scheduler")
        _refuse_what_stays(plan)
        distributed: Any = importlib.import_module("distributed")
        try:
            self._client = distributed.Client(address, timeout="20s")
        except (OSError, ValueError) as error:
            expected = "the address of a Dask scheduler, as tcp://host:8786"
            raise ConfigError(
                [
                    Problem(
                        "no scheduler answers",
                        where="--scheduler",
                        got=f"{address} ({error})",
                        expected=expected,
                    )
                ]
            ) from None
        self.cores = max(1, sum(self._client.nthreads().values()))
        packed = pickle.dumps(bundle(plan))
        self._digest = hashlib.sha256(packed).hexdigest()
        self._bundle = self._client.scatter(packed, broadcast=True)

    def rows(self, orders: Iterator[Order], is_over: Callable[[], bool]) -> Iterator[Row | None]:
        """Make runs; see `Crew.rows`. The batches of a worker that is lost are made by another one."""
        wait = importlib.import_module("distributed").wait
        going: dict[Any, int] = {}
        size = 1
        more = True
        while True:
            while more and len(going) < _BATCHES_A_CORE * self.cores:
                batch = [order for _, order in zip(range(size), orders, strict=False)]
                more = len(batch) == size
                if batch:
                    given = pickle.dumps(batch)
                    task = self._client.submit(
                        run_batch, self._bundle, self._digest, given, pure=False, retries=3
                    )
                    going[task] = size
            if not going:
                return
            try:
                done = wait(list(going), timeout=_LOOK_SECONDS, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                done = set()
            for future in done:
                del going[future]
                seconds, answer = future.result()
                rows: list[Row] = pickle.loads(answer)
                size = max(
                    1, min(_MOST_IN_BATCH, int(_BATCH_SECONDS * len(rows) / max(seconds, 1e-6)), 4 * size)
                )
                yield from rows
            yield None
            if is_over():
                self._client.cancel(list(going), force=True)
                return

    def close(self) -> None:
        """Leave the cluster as it was."""
        self._client.close()


def _refuse_what_stays(plan: Plan) -> None:
    """Refuse campaigns whose runs read files by paths of this machine."""
    problems = [
        Problem("needs a file of this machine in each run", where=f"vary.{key}", expected="a value of an FMU")
        for key, target in plan.varied.targets.items()
        if target.is_structural
    ]
    problems += [
        Problem(
            "needs a file of this machine in each run",
            where=f"keep.measures.{name}",
            expected="another measure",
        )
        for name, measure in plan.measures.items()
        if measure.function is not None
    ]
    if problems:
        raise ConfigError(problems)
