"""Sums over all pairs of long chains by a tree: against direct sums, with N, and in a run.

Three shapes: a straight chain, a coil (a helix of radius 6 d, its turns 4 d apart) and a random
walk whose direction diffuses over 20 d. Each tree is timed beside the direct sum, in turns. On long
chains the direct sum is timed on a sample of spheres, each of which sums over all others.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from nrchain import Scene, load_scene
from nrchain.motion.model import Model
from validation.performance.growth import exponent, wavy
from validation.performance.scenes import LONG_RANGE, MODES, PROJECT
from validation.performance.timing import in_child
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

ACCURACY = 1e-4
SPACING, PERSISTENCE = 10.0, 20
SAMPLE = 500
"""Spheres at which the direct sum is timed, and the error measured."""

BARS = {
    10_000: {"straight": 4.0, "coil": 3.0, "random walk": 1.5},
    100_000: {"straight": 40.0, "coil": 30.0, "random walk": 7.0},
}
"""Times faster than the direct sum, by number of spheres and shape."""

ROOM = 6.0
"""Memory that the run of 1e5 spheres may take, in GiB."""


@dataclass(frozen=True)
class Sums:
    """Seconds of the sums of slip and friction by tree and directly, of their derivatives, and
    the error of the trees relative to the largest value."""

    tree: float
    direct: float
    product: float
    error: float


def compare(recorder: Recorder) -> None:
    """Record times and errors of trees, the exponent of the time with N, and a long run."""
    counts = [2000, 8000] if recorder.quick else [10_000, 100_000]
    found = {
        (shape, count): _sums(shape, count, rounds=3 if recorder.quick else 7)
        for count in counts
        for shape in SHAPES
    }
    for (shape, count), sums in found.items():
        _record(recorder, shape, count, sums)
    for shape in SHAPES:
        times = [found[shape, count].tree for count in counts]
        recorder.bound(
            f"exponent of trees from N = {counts[0]} to {counts[1]}, {shape}",
            exponent(counts, times),
            most=1.5 if shape == "random walk" else 1.2,
            source=PROJECT,
        )
    recorder.table(
        "Trees",
        ["Shape", "N", "Tree (ms)", "Direct (ms)", "Times faster", "Product (ms)", "Error"],
        [
            (*key, 1e3 * s.tree, 1e3 * s.direct, s.direct / s.tree, 1e3 * s.product, s.error)
            for key, s in found.items()
        ],
        f"Slip of four modes and friction of all pairs at an accuracy of {ACCURACY:g}, one thread: "
        f"medians of turns. The direct sum is timed at {SAMPLE} spheres and scaled to all. The "
        "error is the largest of those of v and ω at these spheres, over the largest value. A "
        "product is the derivative along one change of poses and wrenches.",
    )
    _long_run(recorder)


def _record(recorder: Recorder, shape: str, count: int, sums: Sums) -> None:
    name, where = f"all pairs by a tree, {shape}, N = {count}", "four modes and friction"
    recorder.benchmark(name, sums.tree, sums.direct, what=f"{where}, error {sums.error:.1e}")
    recorder.bound(f"{name}: error", sums.error, most=ACCURACY, source="slip.accuracy")
    bar = BARS.get(count, {}).get(shape, 1.0)
    recorder.bound(f"{name}: times faster", sums.direct / sums.tree, least=bar, source=PROJECT)


def _sums(shape: str, count: int, rounds: int) -> Sums:
    """Time and check the sums of one chain."""
    keys = {"chain.particles": count, "slip.accuracy": ACCURACY, "run.end": 1.0}
    stiffness = {"elasticity.stretch": 200.0, "elasticity.shear": 200.0}
    model = Model(load_scene(keys | stiffness | MODES | LONG_RANGE))
    slip, friction = model.slip, model.friction
    assert friction
    rng = np.random.default_rng(1)
    positions = SHAPES[shape](count, rng)
    frames = _frames(positions, rng)
    wrenches, poses = rng.normal(size=(2, count, 6))
    spheres = np.linspace(0, count - 1, min(SAMPLE, count)).astype(int)
    seconds, product = np.empty((rounds, 3)), np.zeros((count, 6))

    def differentiate() -> None:
        slip.add_product(poses, product)
        friction.add_product(poses, wrenches, product)

    with one_thread():
        for turn in range(-1, rounds):
            begin, twists = time.perf_counter(), np.zeros((2, count, 6))
            slip.add_twists(positions, frames, twists[0])
            friction.apply(positions, wrenches, twists[1])
            summed = time.perf_counter()
            exact = slip.direct_twists(spheres), friction.direct_twists(spheres)
            checked = time.perf_counter()
            differentiate()  # the first product at these poses also takes gradients
            prepared = time.perf_counter()
            differentiate()
            if turn >= 0:  # the first turn compiles
                last = time.perf_counter()
                seconds[turn] = summed - begin, checked - summed, last - prepared
    tree, direct, each = np.median(seconds, axis=0).tolist()
    error = max(_error(t, e, spheres) for t, e in zip(twists, exact, strict=True))
    return Sums(tree, direct * count / len(spheres), each, error)


def _error(twists: np.ndarray, exact: np.ndarray, spheres: np.ndarray) -> float:
    """The larger of the errors of v and ω, each over its largest value."""
    parts = slice(3), slice(3, 6)
    return max(
        float(np.abs(twists[spheres] - exact)[:, p].max() / np.abs(twists[:, p]).max())
        for p in parts
    )


def _long_run(recorder: Recorder) -> None:
    """Record the time and the memory of fifty steps of a long chain, in a process of its own."""
    count, steps = (4000, 5) if recorder.quick else (100_000, 50)
    scene: Scene = wavy(count, 1e4, **LONG_RANGE, **{"run.max_steps": steps})
    found = in_child(scene)
    recorder.check(
        f"long-range run of N = {count}: steps", steps, found["steps"], 0.0, source="run.max_steps"
    )
    recorder.bound(
        f"long-range run of N = {count}, {steps} steps: memory (GiB)",
        found["mebibytes"] / 1024,
        most=ROOM,
        source=PROJECT,
    )
    recorder.text(
        f"A run of {count} spheres with slip (2s) and friction of all pairs, an accuracy of "
        f"{scene.pair_accuracy:g}, takes {found['wall_time']:.0f} s for {steps} steps, with "
        f"{found['evaluations']:.0f} right-hand sides and {found['solves']:.0f} solves, and "
        f"{found['mebibytes'] / 1024:.2g} GiB."
    )


def _straight(count: int, rng: np.random.Generator) -> np.ndarray:
    return SPACING * np.arange(count)[:, None] * np.array([1.0, 0.0, 0.0])


def _coil(count: int, rng: np.random.Generator) -> np.ndarray:
    radius, rise = 6.0 * SPACING, 4.0 * SPACING
    angle = SPACING * np.arange(count) / np.hypot(radius, rise / (2 * np.pi))
    along = rise * angle / (2 * np.pi)
    return np.stack([along, radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def _walk(count: int, rng: np.random.Generator) -> np.ndarray:
    direction, steps = np.array([1.0, 0.0, 0.0]), np.empty((count, 3))
    for step in steps:
        direction = direction + rng.normal(size=3) / np.sqrt(PERSISTENCE)
        direction /= np.linalg.norm(direction)
        step[:] = direction
    return SPACING * np.cumsum(steps, axis=0)


SHAPES = {"straight": _straight, "coil": _coil, "random walk": _walk}


def _frames(positions: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Frames (N, 3, 3) whose e_1 is nearly along the chain."""
    along = np.gradient(positions, axis=0) + rng.normal(size=positions.shape)
    first = along / np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(first, rng.normal(size=positions.shape))
    second = across / np.linalg.norm(across, axis=1)[:, None]
    return np.stack([first, second, np.cross(first, second)], axis=1)
