"""Rates, thresholds, runs where kinds differ, regions: a diagram from the results of its jobs.

The jobs follow from the request and from earlier results alone. The order in which they end, and
the number of workers, change nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from nrchain.diagrams.curves import Curve, Do, trace
from nrchain.diagrams.linear import Length, Lengths, Rate, rate
from nrchain.diagrams.mesh import Cell, Mesh
from nrchain.diagrams.plane import Axis, Plane, Site
from nrchain.diagrams.regions import Region, connected
from nrchain.diagrams.trials import UNDECIDED, PhasePoint, Trial, run_trial
from nrchain.diagrams.verification import Verification, verify
from nrchain.jobs.crew import Job
from nrchain.scene.loading import load_scene
from nrchain.scene.toml import flat_keys


@dataclass(frozen=True)
class Request:
    """What decides a diagram.

    Attributes
    ----------
    plane
        The scene and its axes.
    starts
        Names of the starts of the runs at each point.
    most
        Most points at which there are runs.
    longest
        Largest end of a run; None for the rule of :class:`~nrchain.diagrams.linear.Lengths`.
    """

    plane: Plane
    starts: tuple[str, ...]
    most: int
    longest: float | None

    def to_mapping(self) -> dict[str, Any]:
        """What a folder keeps of it."""
        plane = self.plane
        axes = {
            name: [axis.key, axis.low, axis.high, axis.count]
            for name, axis in (("x", plane.x), ("y", plane.y))
        }
        last = {"levels": plane.levels, "starts": list(self.starts)}
        return (
            axes
            | last
            | {"most": self.most, "longest": self.longest}
            | flat_keys(plane.scene.to_mapping())
        )

    @classmethod
    def from_mapping(cls, table: Mapping[str, Any]) -> Request:
        """The request that a folder keeps."""
        scene = load_scene({key: v for key, v in table.items() if key not in _OWN})
        plane = Plane(scene, Axis(*table["x"]), Axis(*table["y"]), table["levels"])
        return cls(plane, tuple(table["starts"]), table["most"], table["longest"])


_OWN = ("x", "y", "levels", "starts", "most", "longest")

WHAT = "phase diagram"
"""What a folder with such a request holds, in messages."""


class Built(NamedTuple):
    """What :func:`build` makes of the results."""

    points: tuple[PhasePoint, ...]
    regions: tuple[Region, ...]
    curves: tuple[Curve, ...]
    cells: tuple[Cell, ...]
    notes: tuple[str, ...]
    is_complete: bool


def build(request: Request, do: Do) -> Built:
    """The diagram of a request; what ``do`` has no result for is left out."""
    plane = request.plane
    linear = Mesh(plane)
    rates = _rates(plane, linear, do)
    curves, notes = trace(plane, linear, rates, do)
    mesh, points, complete = _explore(request, rates, do)
    regions, verified = _verify(request, mesh, points, do)
    notes += _said(request, mesh, points)
    return Built(
        points=tuple(points.values()),
        regions=tuple(regions),
        curves=curves,
        cells=tuple(sorted(mesh.cells)),
        notes=tuple(notes),
        is_complete=complete and verified,
    )


def _rates(plane: Plane, mesh: Mesh, do: Do) -> dict[Site, Rate]:
    """Rates on the coarse grid, and on finer ones where their signs differ."""
    rates: dict[Site, Rate] = {}
    sites = mesh.sites()
    while sites:
        new = _rates_at(plane, sites, do)
        rates |= new
        if len(new) < len(sites):
            break
        sites = mesh.refine({site: one.sign for site, one in rates.items()})
    return rates


def _rates_at(plane: Plane, sites: Sequence[Site], do: Do) -> dict[Site, Rate]:
    jobs = [Job(f"rate {i} {j}", rate, (plane.at((i, j)),)) for i, j in sites]
    found = zip(sites, do(jobs), strict=True)
    return {site: Rate.of(result) for site, result in found if result is not None}


def _explore(
    request: Request, rates: dict[Site, Rate], do: Do
) -> tuple[Mesh, dict[Site, PhasePoint], bool]:
    """The points with their runs, in order, and whether there are all of them."""
    plane = request.plane
    mesh = Mesh(plane)
    sites, complete = mesh.sites(), True
    lengths = Lengths(
        plane.scene, [rates[site] for site in sites if site in rates], request.longest
    )
    points: dict[Site, PhasePoint] = {}
    while sites:
        missing = [site for site in sites if site not in rates]
        rates |= _rates_at(plane, missing, do)
        known = [site for site in sites if site in rates]
        points |= _points(request, known, rates, lengths, do)
        complete = complete and all(site in points for site in sites)
        if not complete:
            break
        kinds = {site: point.kinds for site, point in points.items()}
        sites = mesh.refine(kinds, request.most - len(points))
    return mesh, points, complete


def _points(
    request: Request,
    sites: Sequence[Site],
    rates: Mapping[Site, Rate],
    lengths: Lengths,
    do: Do,
) -> dict[Site, PhasePoint]:
    """Points with the runs from all starts."""
    plane = request.plane
    given: list[tuple[Site, str, Length]] = [
        (site, start, lengths.of(rates[site])) for site in sites for start in request.starts
    ]
    jobs = [
        Job(f"run {site[0]} {site[1]} {start}", run_trial, (plane.at(site), start, length))
        for site, start, length in given
    ]
    trials: dict[Site, list[Trial]] = {site: [] for site in sites}
    for (site, start, length), result in zip(given, do(jobs), strict=True):
        if result is not None:
            trials[site].append(Trial.of(start, length, result))
    return {
        site: PhasePoint(
            site, *plane.place(site), rates[site].growth, rates[site].frequency, tuple(own)
        )
        for site, own in trials.items()
        if len(own) == len(request.starts)
    }


def _verify(
    request: Request, mesh: Mesh, points: Mapping[Site, PhasePoint], do: Do
) -> tuple[list[Region], bool]:
    """The regions with what verifies them, and whether all of it is there."""
    plane = request.plane
    regions = connected(plane, mesh, points)
    ordered = list(points.values())
    tasks: list[tuple[int, PhasePoint, Trial]] = []
    for place, region in enumerate(regions):
        point = ordered[region.inner]
        for kind in region.kinds:
            if kind not in UNDECIDED:
                trial = next(one for one in point.trials if one.kind == kind)
                tasks.append((place, point, trial))
    jobs = [_verifying(plane, point, trial) for _, point, trial in tasks]
    results = do(jobs)
    for (place, point, trial), result in zip(tasks, results, strict=True):
        if result is not None:
            one = Verification.of((point.x, point.y), trial, result)
            regions[place] = replace(regions[place], verified=(*regions[place].verified, one))
    return regions, all(result is not None for result in results)


def _verifying(plane: Plane, point: PhasePoint, trial: Trial) -> Job:
    i, j = point.site
    arguments = plane.at(point.site), trial.start, trial.kind, trial.length
    return Job(f"verify {i} {j} {trial.start}", verify, arguments)


def _said(request: Request, mesh: Mesh, points: Mapping[Site, PhasePoint]) -> list[str]:
    """What a reader should know: runs that failed or did not settle, and an end of the budget."""
    notes = []
    trials = [trial for point in points.values() for trial in point.trials]
    for kind, word in zip(UNDECIDED, ("did not settle", "failed"), strict=True):
        own = [trial for trial in trials if trial.kind == kind]
        if own:
            why = f", the first because {own[0].why}" if own[0].why else ""
            notes.append(f"{len(own)} of {len(trials)} runs {word}{why}")
    labels = {site: point.kinds for site, point in points.items()}
    if mesh.mixed(labels):
        notes.append(
            f"boundaries are not refined to the end: most = {request.most} points are used up"
        )
    missing = [point for point in points.values() if point.growth != point.growth]
    if missing:
        notes.append(
            f"the straight chain has no spectrum at {len(missing)} of {len(points)} points"
        )
    return notes
