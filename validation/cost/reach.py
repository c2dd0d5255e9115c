"""Slip of 1, 2, 4, … neighbours, up to all pairs: the error and cost of each reach.

Trajectories of the shipped scenes are compared with the same scene with all pairs; distances are
divided by the longest path of a sphere. Growth rates and frequencies of bending waves come from the
lattice operator of the endless chain, whose sums over all pairs are exact. Their cost is that of
one right-hand side of a chain of 2048 spheres.
"""

from __future__ import annotations

import time
from statistics import median

import numba
import numpy as np

from nrchain import load_scene, simulate
from nrchain.accuracy.timing import measure_all
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from nrchain.theory.lattice_sums import Reach
from validation.cost import figures
from validation.cost.results import Reached, rate_marks
from validation.report.recorder import Recorder
from validation.report.uniform_chains import LIMP, STRENGTHS, branch_rates, uniform_chain

SCENES = {"2s": "buckling", "3a": "helix-left", "3t": "wave", "4a": "spiral-left"}
PHASE = 0.1
"""qd of the waves: 63 spheres a wavelength."""
SPHERES = 2048
REPEATS = 21


def compare(recorder: Recorder) -> None:
    """Record trajectories and rates of all modes by reach."""
    found: dict[str, list[Reached]] = {}
    for label in SCENES:
        recorder.step(f"reach: {label}")
        found[label] = _mode(recorder, label)
    rows = [
        (
            p.label, p.reach, p.until, p.path, p.measured and p.measured.position,
            p.measured and p.measured.median, p.measured and p.measured.work.steps, p.rate,
            1e6 * p.once, rate_marks(found[p.label], p),
        )
        for label in found
        for p in found[label]
    ]  # fmt: skip
    recorder.table(
        "Reach",
        ["Mode", "Neighbours", "Up to t", "Trajectory, over its path",
         "Trajectory [a]", "Seconds", "Steps", f"Λ at qd = {PHASE:g}",
         f"Right-hand side, N = {SPHERES} [µs]", "Marks"],
        rows,
        "Distance from all pairs: trajectories of the shipped scenes, and rates of bending waves "
        "that the slip alone gives the endless chain. Right-hand sides on one thread.",
    )  # fmt: skip
    recorder.figure(
        "Reach",
        figures.reach(found),
        "(a) Largest distance of a sphere from the run with all pairs, over the longest path in "
        "that run, against processor time; labels are neighbours a side. (b) Relative error of the "
        "rate of a bending wave at qd = 0.1 against the time of one right-hand side. Rings: the "
        "default, nearest neighbours. Squares: the least reach within 1 %, 0.1 % and 1e-6.",
    )
    recorder.text(
        "**Reach.** Nearest neighbours are the model of the paper's theory. They do not "
        "approximate all pairs: the error of the rates falls as k⁻² of the reach k for 2s and "
        "faster for the others, and a chain that buckles from noise amplifies the error. On chains "
        "of tens of spheres all pairs cost little more time than a few neighbours."
    )


def _mode(recorder: Recorder, label: str) -> list[Reached]:
    scene = load_scene(SCENES[label])
    last = scene.chain.particles - 1
    reaches: list[Reach] = [1, 2, 4, 8, 16, 32, 64, 128, 256, "all"]
    if recorder.quick:
        reaches = [1, 4, 16, 128, "all"]
    own = {
        k: load_scene(scene, **{"slip.neighbours": k}) for k in reaches if k == "all" or k < last
    }
    full = simulate(own["all"])
    while full.status != "completed":
        until = {"run.end": 0.9 * float(full.time[-1])}
        own = {k: load_scene(one, **until) for k, one in own.items()}
        full = simulate(own["all"])
    path = np.linalg.norm(full.positions - full.positions[0], axis=-1).max()
    runs = measure_all(
        {str(k): one for k, one in own.items()},
        full,
        repeats=1 if recorder.quick else 5,
        budget=1.0 if recorder.quick else 15.0,
    )
    rates = [_rate(label, k) for k in reaches]
    seconds = _right_hand_sides(label, reaches, 3 if recorder.quick else REPEATS)
    errors = [abs(rate - rates[-1]) / abs(rates[-1]) for rate in rates]
    recorder.bound(
        f"{label}: error of the rate falls from nearest neighbours to 128 by",
        errors[0] / errors[reaches.index(128)],
        least=50.0,
        source="partial sums over the distance",
    )
    return [
        Reached(
            label,
            k,
            own["all"].run.end,
            runs[str(k)].position / float(path) if str(k) in runs else None,
            runs.get(str(k)),
            float(error),
            once,
        )
        for k, error, once in zip(reaches, errors, seconds, strict=True)
    ]


def _rate(label: str, reach: Reach) -> complex:
    """Λ of the slip alone, without the rotation of the whole chain."""
    chain = uniform_chain({label: STRENGTHS[label]}, LIMP | {"slip.neighbours": reach})
    return complex(branch_rates(chain, np.array([PHASE]))[0])


def _right_hand_sides(label: str, reaches: list[Reach], repeats: int) -> list[float]:
    """Median seconds of one evaluation of all twists, in turns and on one thread.

    With several threads, times would depend on other programs that run on the machine.
    """
    chains = [
        load_scene(
            SCENES[label],
            **{"chain.particles": SPHERES, "slip.neighbours": k, "start.amplitude": 0},
        )
        for k in reaches
    ]
    models = [(Model(chain), *initial_poses(chain)) for chain in chains]
    for model, *poses in models:
        model.twists(*poses)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    times: list[list[float]] = [[] for _ in reaches]
    for _ in range(repeats):
        for (model, *poses), spent in zip(models, times, strict=True):
            began = time.perf_counter()
            model.twists(*poses)
            spent.append(time.perf_counter() - began)
    numba.set_num_threads(threads)
    return [median(spent) for spent in times]
