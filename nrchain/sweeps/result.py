"""The result of a sweep: its points, what is observed at each, and how each run ended."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from nrchain.errors import TrajectoryError
from nrchain.inputs.names import Named, unknown_name
from nrchain.jobs.crew import FAILED
from nrchain.jobs.ledger import Result, read_request, read_results
from nrchain.notebook import table_html
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.scene.toml import flat_keys
from nrchain.sweeps.observables import Value
from nrchain.sweeps.points import portable
from nrchain.sweeps.tables import columns, to_dataset
from nrchain.sweeps.without_value import WithoutValue, without_value

WHAT = "sweep"
"""What the folder of a sweep holds, in messages."""


@dataclass(frozen=True, repr=False)
class SweepPoint:
    """One point of a sweep: what it changes, how its run ended, what was observed, and the cost.

    Attributes
    ----------
    name
        Sixteen digits that follow from all keys of the scene; names a trajectory that is kept.
    values
        The keys that it changes, and their values.
    outcome
        ``"completed"``, ``"stopped"`` with a cause, or ``"failed"``.
    cause
        Why a run stopped: a value of :class:`nrchain.Cause`, or None.
    reason
        How a run stopped, or what a failed one raised, in words; empty for others.
    observables
        Numbers and words by name; None where they cannot be measured.
    unmeasured
        Why they cannot, by name.
    counters
        Steps, evaluations of the right-hand side and so on.
    warnings
        What the run warned of.
    seconds, processor_seconds
        Wall time and processor time, no part of a comparison.
    versions
        Of nrchain and of the packages it ran with, no part of a comparison.
    trajectory
        The file that was kept, no part of a comparison.

    >>> scene = {"chain": {"particles": 2}, "run": {"end": 1.0}}
    >>> nrchain.sweep(scene, {"run.end": [0.5]}, observe="end.time").points[0]
    <SweepPoint run.end = 0.5: completed; end.time 0.5>
    """

    name: str
    values: Mapping[str, Any]
    outcome: str
    cause: str | None
    reason: str
    observables: Mapping[str, Value]
    unmeasured: Mapping[str, str]
    counters: Mapping[str, int]
    warnings: tuple[str, ...]
    seconds: float | None = field(compare=False)
    processor_seconds: float | None = field(compare=False)
    versions: Mapping[str, str] = field(compare=False)
    trajectory: Path | None = field(compare=False)

    @classmethod
    def of(
        cls, name: str, values: Mapping[str, Any], result: Result, folder: Path | None
    ) -> SweepPoint:
        """The point of a result, with the values of all keys that the sweep changes."""
        counters = dict(result.get("counters", {}))
        times = [counters.pop(key, None) for key in ("wall_time", "processor_time")]
        kept = result.get("trajectory")
        return cls(
            name=name,
            values=Named(values),
            outcome=FAILED if FAILED in result else result["outcome"],
            cause=result.get("cause"),
            reason=result.get(FAILED) or result.get("reason", ""),
            observables=Named(result.get("observables", {})),
            unmeasured=dict(result.get("unmeasured", {})),
            counters=Named({key: int(count) for key, count in counters.items()}),
            warnings=tuple(result.get("warnings", ())),
            seconds=times[0],
            processor_seconds=times[1],
            versions=dict(result.get("versions", {})),
            trajectory=folder / kept if folder and kept else None,
        )

    def __repr__(self) -> str:
        shown = ", ".join(f"{key} = {value!r}" for key, value in self.values.items())
        found = ", ".join(f"{key} {value!r}" for key, value in self.observables.items())
        return f"<SweepPoint {shown}: {self.outcome}; {found}>"[:300]

    def _repr_html_(self) -> str:
        rows = [*self.values.items(), ("outcome", self.outcome), *self.observables.items()]
        return table_html(f"Point {self.name}", rows)


@dataclass(frozen=True, repr=False)
class Sweep:
    """One scene at many points: how each run ended, and what was observed.

    Attributes
    ----------
    scene
        The scene that is varied.
    keys
        The keys that the points change.
    points
        In the order of their values, whatever the order in which they were run.
    folder
        Where it is kept, no part of a comparison; None for a sweep in memory.

    >>> scene = {"chain": {"particles": 2}, "run": {"end": 1.0}}
    >>> found = nrchain.sweep(scene, {"run.end": "1:2:2"})
    >>> found.keys, len(found), found.points[1].values["run.end"]
    (('run.end',), 2, 2.0)
    """

    scene: Scene
    keys: tuple[str, ...]
    points: tuple[SweepPoint, ...]
    folder: Path | None = field(default=None, compare=False)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """The sweep of a folder, with what is finished, of all its shards.

        Raises :class:`~nrchain.errors.TrajectoryError` where there is none.
        """
        folder = Path(folder)
        try:
            scene = load_scene(read_request(folder, WHAT))
            return cls.of(scene, read_results(folder), folder)
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise TrajectoryError(f"{folder}: is damaged, or no sweep: {error}") from None

    @classmethod
    def of(cls, scene: Scene, results: Mapping[str, Result], folder: Path | None) -> Self:
        """The sweep of results by name."""
        keys = tuple(dict.fromkeys(key for one in results.values() for key in one["point"]))
        base = portable(flat_keys(scene.to_mapping()))
        points = [
            SweepPoint.of(
                name, {key: one["point"].get(key, base.get(key)) for key in keys}, one, folder
            )
            for name, one in results.items()
        ]
        points.sort(key=lambda point: [_rank(point.values[key]) for key in keys])
        return cls(scene, keys, tuple(points), folder)

    @property
    def observables(self) -> tuple[str, ...]:
        """The names of all that was observed at some point."""
        return tuple(dict.fromkeys(name for one in self.points for name in one.observables))

    @property
    def failed(self) -> tuple[SweepPoint, ...]:
        """The points whose runs failed."""
        return tuple(point for point in self.points if point.outcome == FAILED)

    @property
    def without_value(self) -> tuple[WithoutValue, ...]:
        """The observables that have no value at some points, with the most frequent cause.

        >>> scene = {"chain": {"particles": 2}, "run": {"end": 1.0}}
        >>> found = nrchain.sweep(scene, {"run.end": [0.5]}, observe="end.error")
        >>> print(*found.without_value)
        end.error at 1 of 1 points; most often: the run has no estimate of its error; set \
run.verify = true
        """
        return tuple(without_value(self.points, self.observables))

    def column(self, name: str) -> list[Any]:
        """The values of a key or of an observable, point by point; None where there are none.

        Raises :class:`~nrchain.errors.UnknownNameError` for any other name.
        """
        if name in self.keys:
            return [point.values[name] for point in self.points]
        if name not in self.observables:
            raise unknown_name(name, (*self.keys, *self.observables))
        return [point.observables.get(name) for point in self.points]

    def scene_at(self, point: SweepPoint) -> Scene:
        """The scene of a point."""
        return load_scene(self.scene, **point.values)

    def table(self) -> dict[str, list[Any]]:
        """Columns by name, one row a point: the form that pandas, Parquet and CSV take.

        The keys that vary, the outcome, the observables, the cost, the versions, and all other
        keys of the scene.
        """
        return columns(self)

    def to_xarray(self) -> Any:
        """The observables as an ``xarray.Dataset``, over the keys that vary.

        Points that do not fill a grid lie along one dimension, ``point``. Needs xarray:
        ``pip install 'nrchain[sweep]'``.
        """
        return to_dataset(self)

    def __len__(self) -> int:
        return len(self.points)

    def _repr_html_(self) -> str:
        names = self.observables
        rows = [
            [*p.values.values(), p.outcome, *(p.observables.get(n, "") for n in names)]
            for p in self.points
        ]
        return table_html(f"Sweep of {len(self)} points", rows, (*self.keys, "outcome", *names))

    def __repr__(self) -> str:
        over, place = ", ".join(self.keys), f", {str(self.folder)!r}" if self.folder else ""
        failed = f", {len(self.failed)} failed" if self.failed else ""
        empty = "".join(f", no {one.name} at {one.points}" for one in self.without_value)
        return f"<Sweep over {over}: {len(self)} points{failed}{place}{empty}>"[:300]


def _rank(value: Any) -> tuple[int, float, str]:
    """Sorts numbers by size, before all else, which is sorted as text."""
    if isinstance(value, (int, float)):
        return 0, float(value), ""
    return 1, 0.0, json.dumps(value)
