"""The work of a sweep: points become jobs, and what a ledger has is not computed again."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nrchain.errors import SceneError
from nrchain.jobs.crew import FAILED, Crew, Job, Progress, WorkersLost
from nrchain.jobs.ledger import Ledger, Result
from nrchain.run.interruption import Interruption
from nrchain.sweeps.adaptive_points import Target
from nrchain.sweeps.executors import Workers
from nrchain.sweeps.observables import Observable
from nrchain.sweeps.point_run import run_point
from nrchain.sweeps.points import Site, portable
from nrchain.sweeps.progress import Counter

AHEAD = 1024
"""Most points that are with an executor at a time."""


@dataclass(frozen=True)
class Shard:
    """One of several equal parts of the points."""

    number: int
    count: int

    @classmethod
    def read(cls, text: str) -> Shard:
        """The shard of ``"2/8"``; raises SceneError."""
        found = re.fullmatch(r"(\d+)/(\d+)", text) if isinstance(text, str) else None
        if found is None or not 1 <= int(found[1]) <= int(found[2]):
            raise SceneError("shard", text, 'must be a number and the number of shards, as "2/8"')
        return cls(int(found[1]), int(found[2]))

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    @property
    def file(self) -> str:
        """The file of its results."""
        return f"results-{self.number}-of-{self.count}.jsonl"

    def of(self, found: Sequence[Site]) -> list[Site]:
        """Its points: one of every ``count``."""
        return list(found[self.number - 1 :: self.count])


class Task:
    """Does points of one sweep, and keeps their results in its ledger."""

    def __init__(
        self,
        observables: Mapping[str, Observable | None],
        kept: Path | None,
        ledger: Ledger,
        counter: Counter,
    ) -> None:
        self._observables, self._ledger, self._counter = observables, ledger, counter
        # workers may have another working directory
        self._kept = None if kept is None else kept.absolute()

    def do(
        self, found: Sequence[Site], workers: Workers, interruption: Interruption, retry: bool
    ) -> None:
        """Run the points that have no result, or lack an observable."""
        jobs = [job for site in found if (job := self._job(site, retry)) is not None]
        known = {site.name for site in found} - {job.name for job in jobs}
        self._counter.begin(len(known), sum(map(self._has_failed, known)))
        while True:
            crew = Crew(self._ledger, workers.executor, interruption, self._count, AHEAD)
            try:
                crew.do(jobs)
                return
            except WorkersLost:
                if not workers.restart():
                    raise

    def observed(self, found: Sequence[Site], name: str) -> list[Target]:
        """An observable at points that are done; None where there is none."""
        results = [self._ledger.results[site.name] for site in found]
        return [result.get("observables", {}).get(name) for result in results]

    def _job(self, site: Site, retry: bool) -> Job | None:
        """The job of a point; None where its result has all that is asked for."""
        held: Result | None = self._ledger.results.get(site.name)
        earlier = held or {}
        known = earlier.get("observables", {})
        missing = {k: what for k, what in self._observables.items() if k not in known}
        if held is not None:
            if not retry if FAILED in held else not missing:
                return None
            del self._ledger.results[site.name]
        values = portable(site.values) if held is None else held["point"]
        arguments = site.scene, missing, earlier, self._kept, site.name
        return Job(site.name, run_point, arguments, {"point": values})

    def _count(self, progress: Progress) -> None:
        self._counter.add(self._has_failed(progress.name))

    def _has_failed(self, name: str) -> bool:
        return FAILED in self._ledger.results[name]
