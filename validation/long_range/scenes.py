"""What nearest neighbours leave out of the paper's buckling, coil, wave and spiral.

The shipped scenes, run as they are, with the slip of all pairs, and with friction between all
spheres as well. Chains of 20 and 40 spheres end before the logarithms are large, and each number
here belongs to its chain.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from nrchain import Trajectory, load_scene, measure, simulate
from validation.report.recorder import Recorder

Array = NDArray[np.float64]

APPROXIMATIONS = {
    "nearest": {},
    "all pairs": {"slip.neighbours": "all"},
    "all pairs, friction": {"slip.neighbours": "all", "friction": "pairwise"},
}
STYLES = {
    "nearest": ("--", "0.5"),
    "all pairs": ("-", "0.6"),
    "all pairs, friction": ("-", "0.0"),
}
SNAPSHOTS = 401


def height(trajectory: Trajectory) -> Array:
    """(T,) root mean square distance of the spheres from the x axis."""
    return np.sqrt((trajectory.positions[:, :, 1:] ** 2).sum(axis=2).mean(axis=1))


def growth_rate(trajectory: Trajectory) -> float:
    """d ln A/dt from 1.5 times the least height to one radius."""
    heights = height(trajectory)
    least = int(np.argmin(heights))
    after = np.arange(len(heights)) > least
    grown = after & (heights > 1.5 * heights[least]) & (heights < 1.0)
    return float(np.polyfit(trajectory.time[grown], np.log(heights[grown]), 1)[0])


def slackening(trajectory: Trajectory) -> float:
    """½ d ln(1 − end-to-end/length)/dt over the first fifth: the decay of the shape's slopes."""
    first = trajectory.time <= 0.2 * trajectory.time[-1]
    slack = 1.0 - measure.straightness(trajectory)[first]
    return 0.5 * float(np.polyfit(trajectory.time[first], np.log(slack), 1)[0])


def last_height(trajectory: Trajectory) -> float:
    return float(height(trajectory)[-1])


def last_straightness(trajectory: Trajectory) -> float:
    return float(measure.straightness(trajectory)[-1])


def last_hand(trajectory: Trajectory) -> float:
    return float(measure.handedness(trajectory).hand[-1])


def speed(trajectory: Trajectory) -> float:
    return measure.translation(trajectory)[0].value


def spin(trajectory: Trajectory) -> float:
    return measure.spin(trajectory).value


def turning(trajectory: Trajectory) -> float:
    """dφ/dt of the projection on the helix the chain started from, over the second half.

    The chain turns as a whole, so this is its rate whatever shape the ends have given it by then.
    """
    wave = measure.wave(trajectory, kind="left")
    late = trajectory.time[-1] / 2
    return measure.rate(wave, late, most_misfit=math.inf).frequency.value


@dataclass(frozen=True)
class Story:
    """A shipped scene, what is measured on it, and the height axis of its figure."""

    scene: str
    title: str
    measures: dict[str, Callable[[Trajectory], float]]
    logarithmic: bool


STORIES = (
    Story(
        "buckling",
        "buckling, 2s",
        {"growth rate": growth_rate, "last height / a": last_height},
        True,
    ),
    Story(
        "helix-left",
        "coil, 3a",
        {
            "growth rate": growth_rate,
            "last height / a": last_height,
            "straightness": last_straightness,
            "hand": last_hand,
        },
        True,
    ),
    Story("wave", "wave, 3t", {"speed": speed, "decay of slopes": slackening}, False),
    Story(
        "spiral-left",
        "spiral, 4a",
        {"spin": spin, "turning of the helix": turning, "decay of slopes": slackening},
        False,
    ),
)


def compare(recorder: Recorder) -> None:
    rows, runs = [], {}
    values: dict[tuple[str, str], list[float]] = {}
    for story in STORIES:
        recorder.step(f"the paper's {story.title}")
        runs[story.scene] = {
            name: simulate(load_scene(story.scene, **changes, **{"run.snapshots": SNAPSHOTS}))
            for name, changes in APPROXIMATIONS.items()
        }
        for what, measured in story.measures.items():
            found = [measured(run) for run in runs[story.scene].values()]
            values[story.scene, what] = found
            rows.append((story.title, what, *found, *(f / found[0] for f in found[1:])))
        ends = [_end(run) for run in runs[story.scene].values()]
        if len(set(ends)) > 1:
            rows.append((story.title, "the run", *ends, "", ""))
    recorder.table(
        "The paper's scenes",
        ["Scene", "Measured", *APPROXIMATIONS, "all / nearest", "with friction / nearest"],
        rows,
        "The shipped scenes with nearest neighbours, with the slip of all pairs, and with friction "
        "between all spheres as well; lengths in a, times in the unit of the scenes.",
        first_page=True,
    )
    _checks(recorder, values)
    recorder.figure(
        "scenes",
        _draw(runs),
        "Distance from the axis (root mean square over the spheres) for the paper's buckling and "
        "coil, slack 1 − end-to-end/length for its wave and spiral, in three approximations. A "
        "line that ends early is a run that stopped.",
    )


def _end(run: Trajectory) -> str:
    return run.status if run.status == "completed" else f"stopped at t = {run.time[-1]:.0f}"


def _checks(recorder: Recorder, values: dict[tuple[str, str], list[float]]) -> None:
    for scene, name in (("buckling", "pushers"), ("helix-left", "torque dipoles")):
        nearest, every, friction = values[scene, "growth rate"]
        recorder.bound(
            f"{name}: growth rate with all pairs over nearest",
            every / nearest,
            least=2.0,
            source="3/2 − ln qd and 4/3 − ln qd, the bending held against it unchanged",
        )
        recorder.bound(
            f"{name}: growth rate with friction between spheres over that without",
            friction / every,
            least=0.5,
            most=2.0,
            source="friction speeds up relaxation and leaves slip alone",
        )
    for number, name in enumerate(APPROXIMATIONS):
        recorder.check(
            f"torque dipoles: hand of the coil, {name}",
            -1,
            values["helix-left", "hand"][number],
            1e-2,
            source="Fig. 5d of the paper",
        )
    m = np.arange(1, 20)
    for scene, what, power in (("wave", "speed", 3), ("spiral-left", "spin", 5)):
        shares = (1 - m / 20) / m**power
        nearest, every, friction = values[scene, what]
        recorder.check(
            f"{scene}: {what}, all pairs over nearest",
            shares.sum() / shares[0],
            every / nearest,
            0.03,
            source=f"Σ (1 − m/N)/m^{power} of a straight chain of N = 20",
        )
        recorder.check(
            f"{scene}: {what}, with friction between spheres over without",
            1,
            friction / every,
            0.02,
            source="slip velocities enter once",
        )


def _draw(runs: dict[str, dict[str, Trajectory]]) -> Figure:
    figure = Figure(figsize=(7.2, 5.0))
    for panel, story in zip(figure.subplots(2, 2).ravel(), STORIES, strict=True):
        for name, run in runs[story.scene].items():
            style, color = STYLES[name]
            drawn = height(run) if story.logarithmic else 1 - measure.straightness(run)
            panel.semilogy(run.time, drawn, style, color=color, label=name)
        panel.set(title=story.title, xlabel="time")
        panel.set_ylabel("height / a" if story.logarithmic else "slack")
    figure.axes[0].legend(loc="lower right")
    return figure
