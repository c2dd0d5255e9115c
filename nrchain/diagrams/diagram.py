"""The phase diagram: points with their runs, regions, thresholds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from nrchain.diagrams.build import WHAT, Request, build
from nrchain.diagrams.curves import Curve, Do
from nrchain.diagrams.mesh import Cell
from nrchain.diagrams.plane import Axis
from nrchain.diagrams.regions import Region
from nrchain.diagrams.trials import PhasePoint
from nrchain.errors import TrajectoryError
from nrchain.jobs.ledger import read_request, read_results
from nrchain.notebook import table_html
from nrchain.scene.scene import Scene
from nrchain.wording import brief, span

COLUMNS = (
    *("x", "y", "growth", "frequency", "region", "start", "kind", "since", "period"),
    *("numbers", "end", "capped", "steps", "seconds", "why"),
)
"""Of the table of runs."""


@dataclass(frozen=True)
class PhaseDiagram:
    """Which attractor a chain reaches, over two numbers of its scene.

    Attributes
    ----------
    scene
        The scene that is varied.
    x, y
        The axes: key, low, high, and the number of points of the first grid.
    levels
        How often the distance of points was halved at most.
    starts
        The starts of the runs at each point.
    points
        Points with their runs: those of the first grid, then finer ones, row by row.
    regions
        Connected points of one kind, from the largest on, each with what verifies it.
    curves
        Lines on which the straight chain turns unstable.
    cells
        The squares (i, j, side) of the plane whose corners are points.
    notes
        What a reader should know, a sentence each.
    is_complete
        Whether all its runs are finished. A diagram that was interrupted is not.

    >>> from nrchain import load_scene, phases
    >>> scene = load_scene("buckling", **{"chain.particles": 5})
    >>> x, y = ("slip.2s", -10.0, 10.0, 2), ("slip.3t", 0.0, 10.0, 2)
    >>> len(phases(scene, x, y, "random", levels=0).points)
    4
    """

    scene: Scene
    x: Axis
    y: Axis
    levels: int
    starts: tuple[str, ...]
    points: tuple[PhasePoint, ...]
    regions: tuple[Region, ...]
    curves: tuple[Curve, ...]
    cells: tuple[Cell, ...] = field(repr=False)
    notes: tuple[str, ...]
    is_complete: bool

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = [
            (one.kind, len(one.points), f"{100.0 * one.share:.1f} %", *map(_ends, (one.x, one.y)))
            for one in self.regions
        ]
        heads = ("region", "points", "part of the plane", self.x.key, self.y.key)
        return table_html(f"Phases of {len(self.points)} points", rows, heads)

    @classmethod
    def open(cls, folder: str | Path) -> Self:
        """The diagram of a folder, with what is finished.

        Raises :class:`~nrchain.errors.TrajectoryError` where there is none.
        """
        table = read_request(Path(folder), WHAT)
        try:
            request = Request.from_mapping(table)
        except (KeyError, TypeError) as error:
            raise TrajectoryError(f"{folder}: is damaged: {error!r}") from None
        results = read_results(Path(folder))
        return cls.made(request, lambda jobs: [results.get(job.name) for job in jobs])

    @classmethod
    def made(cls, request: Request, do: Do) -> Self:
        """The diagram of a request, from the results of its jobs."""
        plane = request.plane
        return cls(plane.scene, plane.x, plane.y, plane.levels, request.starts, *build(request, do))

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of all regions, the one with the largest part of the plane first."""
        return tuple(dict.fromkeys(region.kind for region in self.regions))

    def region_of(self, place: int) -> Region:
        """The region of the point at a place."""
        return next(region for region in self.regions if place in region.points)

    def rows(self) -> Iterator[dict[str, Any]]:
        """The table of runs, by :data:`COLUMNS`: several for each point."""
        regions = {place: n for n, region in enumerate(self.regions) for place in region.points}
        for place, point in enumerate(self.points):
            for trial in point.trials:
                numbers = " ".join(f"{key}={value:.6g}" for key, value in trial.numbers.items())
                values = (
                    *(point.x, point.y, point.growth, point.frequency, regions[place]),
                    *(trial.start, trial.kind, trial.since, trial.period, numbers),
                    *(trial.end, trial.length.is_capped, trial.steps, trial.seconds, trial.why),
                )
                yield dict(zip(COLUMNS, values, strict=True))

    def write_table(self, path: str | Path) -> Path:
        """Write the table of runs as comma-separated values."""
        import csv

        from nrchain.trajectory.file import file_errors

        path = Path(path)
        with (
            file_errors(path, "cannot be written"),
            path.open("w", newline="", encoding="utf-8") as f,
        ):
            writer = csv.DictWriter(f, COLUMNS)
            writer.writeheader()
            writer.writerows(self.rows())
        return path


def _ends(ends: tuple[float, float]) -> str:
    return span(*(f"{value:g}" for value in ends))
