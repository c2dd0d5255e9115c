"""Is ``nrchain.flow`` the flow of the fluid about a chain?

Alone, a sphere has an exact flow: the resolved solution and PyStokes' ``Flow`` have to give the
same, on its surface and away from it. In a chain, the average of the flow over the surface of a
sphere is its motion, and the curl of the flow is the vorticity. What the flow leaves out,
reflections between spheres, is measured against resolved pairs. The tree has to be as accurate as
it says, and is timed against the direct sum.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import nrchain
from nrchain.hydrodynamics import lamb, pystokes
from nrchain.hydrodynamics.resolved import ResolvedSpheres
from nrchain.scene.poses import initial_poses
from validation.report.paper import LABELS
from validation.report.recorder import Recorder
from validation.report.style import MARKERS, SHADES

Array = NDArray[np.float64]

RADIUS, VISCOSITY = 0.7, 1.3
AXIS = np.array([0.36, 0.48, 0.8])
FRAME = np.array([AXIS, [0.8, -0.6, 0.0], np.cross(AXIS, [0.8, -0.6, 0.0])])
WRENCH = np.array([1.1, -0.4, 0.7]), np.array([-0.3, 0.9, 0.5])

FACTORS = (2.5, 3.0, 4.0, 6.0, 9.0, 14.0)
"""Distances of pairs, in radii."""

SIZES = ((2000, 4000), (8000, 16_000), (32_000, 64_000), (64_000, 128_000))
"""Spheres and points of the sums that are timed."""

MOST_DIRECT = 3e8
"""Most pairs that are summed directly to compare."""


def study(recorder: Recorder) -> None:
    recorder.step("one sphere")
    for label in (*LABELS, "force", "torque"):
        _one_sphere(recorder, label)
    recorder.step("chains")
    _motion(recorder)
    _vorticity(recorder)
    _periodic(recorder)
    recorder.step("reflections")
    _reflections(recorder)
    recorder.step("the tree")
    _tree(recorder)


def one(label: str) -> nrchain.Scene:
    """A scene whose first sphere, at the origin, has one mode, a force or a torque."""
    changes: dict[str, Any] = {
        "chain": {"particles": 2, "radius": RADIUS, "viscosity": VISCOSITY, "spacing": 1e4},
        "elasticity": {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0},
        "start": {
            "shape": "given",
            "positions": [[0.0, 0.0, 0.0], [1e18, 0.0, 0.0]],
            "frames": [FRAME.tolist(), FRAME.tolist()],
        },
        "run": {"end": 1.0},
    }
    if label in LABELS:
        changes["slip"] = {label: [1.0, 0.0]}
    else:
        changes["field"] = {label: WRENCH[label == "torque"].tolist()}
    return nrchain.load_scene(changes)


def _one_sphere(recorder: Recorder, label: str) -> None:
    scene, is_mode = one(label), label in LABELS
    solved = ResolvedSpheres(np.zeros((1, 3)), radius=RADIUS, viscosity=VISCOSITY, order=8)
    wrench = [np.zeros((1, 3)), np.zeros((1, 3))]
    if not is_mode:
        wrench[label == "torque"][0] = WRENCH[label == "torque"]
    slip = {label: 1.0} if is_mode else {}
    resolved = solved.mobility_problem(FRAME[None], slip, wrenches=(wrench[0], wrench[1]))
    normals, _ = lamb.sphere_grid(10)
    for name, factor in (("on its surface", 1.0), ("3 a from its centre", 3.0)):
        points = factor * RADIUS * normals
        gap = _relative(nrchain.flow(scene, points).velocity, resolved.velocity(points))
        recorder.check(
            f"{label}: flow of one sphere {name} against the resolved solution",
            0,
            gap,
            1e-11,
            source="rigid motion plus slip on the surface, Lamb's solution outside",
        )
    points = np.random.default_rng(3).uniform(2.0, 9.0, (40, 3)) * RADIUS
    vector = AXIS if is_mode else WRENCH[label == "torque"]
    size = float(np.linalg.norm(vector))
    theirs = pystokes.flow_at(
        label, points, np.zeros((1, 3)), vector[None] / size, np.array([size]), RADIUS, VISCOSITY
    )
    recorder.check(
        f"{label}: flow of one sphere against PyStokes' Flow, calibrated",
        0,
        _relative(nrchain.flow(scene, points).velocity, theirs),
        1e-12,
        source="factors in nrchain/hydrodynamics/pystokes.py",
    )


def crooked(ends: str = "free", particles: int = 6) -> nrchain.Scene:
    """A bent chain in which everything acts, with a ≠ 1 and η ≠ 1."""
    field = {"body_torque": [4.0, 5.0, -2.0]}
    if ends != "periodic":
        field["force"] = [1.0, -2.0, 3.0]
    table: dict[str, Any] = {
        "chain": {
            "particles": particles,
            "radius": RADIUS,
            "viscosity": VISCOSITY,
            "spacing": 6.0,
            "ends": ends,
        },
        "friction": "pairwise",
        "slip": {
            "neighbours": "all",
            "finite_size": True,
            "2s": 40.0,
            "3a": {"strength": 9.0, "axis": [0.0, 1.0, 0.5]},
            "3t": 11.0,
            "4a": 200.0,
        },
        "flow": {
            "gradient": [[0.0, 0.3, -0.1], [0.0, 0.2, 0.4], [0.0, -0.3, -0.2]],
            "finite_size": True,
        },
        "field": field,
        "start": {"shape": "random", "amplitude": 0.5, "seed": 3},
        "run": {"end": 1.0},
    }
    return nrchain.load_scene(table)


def _motion(recorder: Recorder) -> None:
    """Faxén: v = ⟨u⟩ and ω = (3/2a)⟨n × u⟩ over the surface of every sphere."""
    normals, weights = lamb.sphere_grid(12)
    for ends in ("free", "clamped", "periodic"):
        scene = crooked(ends)
        positions, frames = initial_poses(scene)
        u = nrchain.flow(scene, positions[:, None] + RADIUS * normals).velocity
        v = np.einsum("p,npk->nk", weights, u)
        w = 1.5 / RADIUS * np.einsum("p,npk->nk", weights, np.cross(normals, u))
        twists = nrchain.contributions(scene, positions, frames).total.twist
        recorder.check(
            f"{ends} chain with all effects: the average flow at its spheres is their motion",
            0,
            _relative(np.hstack([v, RADIUS * w]), twists * np.repeat([1.0, RADIUS], 3)),
            1e-10,
            source="Faxén's laws, and the twists of the model",
        )


def _vorticity(recorder: Recorder) -> None:
    scene = crooked()
    positions, _ = initial_poses(scene)
    points = positions[2] + np.random.default_rng(4).uniform(1.5, 4.0, (50, 3))
    step = 1e-3

    def slopes(size: float) -> Array:
        moved = [
            nrchain.flow(scene, points + h).velocity - nrchain.flow(scene, points - h).velocity
            for h in size * np.eye(3)
        ]
        return np.stack(moved, axis=1) / (2 * size)

    gradient = (4 * slopes(step / 2) - slopes(step)) / 3  # ∂_k u_i at [:, k, i]
    curl = np.stack(
        [gradient[:, (k + 1) % 3, (k + 2) % 3] - gradient[:, (k + 2) % 3, (k + 1) % 3]
         for k in range(3)], axis=1,
    )  # fmt: skip
    vorticity = nrchain.flow(scene, points).vorticity
    source = "differences of the velocity, to fourth order"
    recorder.check("vorticity is the curl", 0, _relative(vorticity, curl), 1e-8, source=source)
    divergence = np.abs(np.trace(gradient, axis1=1, axis2=2)).max() / np.abs(gradient).max()
    recorder.check("the fluid is incompressible", 0, divergence, 1e-8, source=source)


def _periodic(recorder: Recorder) -> None:
    """The flow of a periodic chain against that of open chains of 2P + 1 periods, P → ∞."""
    none = [0.0, 0.0, 0.0]
    straight = {
        "field": {"body_torque": none},
        "start.shape": "straight",
        "flow": {"gradient": [none] * 3},
    }
    scene = nrchain.load_scene(crooked("periodic"), **straight)
    count, period = scene.chain.particles, scene.length
    points = np.array([[3.0, 4.0, 1.0], [20.0, -9.0, 30.0], [10.0, 400.0, 5.0]])
    sums = []
    for most in (1000, 2000):
        particles = count * (2 * most + 1)
        copy = nrchain.load_scene(scene, **{"chain.ends": "free", "chain.particles": particles})
        moved = points + np.array([most * period, 0.0, 0.0])
        sums.append(nrchain.flow(copy, moved, parts=["slip"], accuracy=0.0).velocity)
    expected = (4 * sums[1] - sums[0]) / 3
    found = nrchain.flow(scene, points, parts=["slip"]).velocity
    recorder.check(
        "periodic chain: its flow is the sum over its images, also far from it",
        0,
        _relative(found, expected),
        1e-6,
        source="open chains of 2001 and 4001 periods, extrapolated",
    )


def _reflections(recorder: Recorder) -> None:
    """What flows about single spheres leave out, on the surfaces and between two spheres."""
    rows, normals = [], lamb.sphere_grid(8)[0]
    order = 12 if recorder.quick else 16
    for factor in FACTORS:
        positions = np.array([[0.0, 0.0, 0.0], [factor * RADIUS, 0.0, 0.0]])
        solved = ResolvedSpheres(positions, radius=RADIUS, viscosity=VISCOSITY, order=order)
        frames = np.array([FRAME, FRAME[[1, 2, 0]]])
        points = (positions[:, None] + 1.5 * RADIUS * normals).reshape(-1, 3)
        clear = np.linalg.norm(points[:, None] - positions, axis=2).min(axis=1) > 1.1 * RADIUS
        row: list[float] = [factor]
        for label in LABELS:
            scene = nrchain.load_scene(
                {
                    "chain": {"particles": 2, "radius": RADIUS, "viscosity": VISCOSITY,
                              "spacing": factor * RADIUS},
                    "slip": {label: 1.0},
                    "elasticity": {"stretch": 0.0, "shear": 0.0, "twist": 0.0, "bend": 0.0},
                    "start": {"shape": "given", "positions": positions.tolist(),
                              "frames": frames.tolist()},
                    "run": {"end": 1.0},
                }
            )  # fmt: skip
            resolved = solved.mobility_problem(frames, {label: 1.0}).velocity(points[clear])
            row.append(_relative(nrchain.flow(scene, points[clear]).velocity, resolved))
        rows.append(row)
    table = np.array(rows)
    recorder.table(
        "What reflections between two spheres add to the flow",
        ["r/a", *LABELS],
        [[f"{row[0]:g}", *(f"{value:.1e}" for value in row[1:])] for row in rows],
        "Largest difference of the flow from the resolved solution 1.5 a from the centres of two "
        "spheres with slip, over the largest flow there.",
        first_page=True,
    )
    for column, label in enumerate(LABELS, start=1):
        slope = np.polyfit(np.log(table[-3:, 0]), np.log(table[-3:, column]), 1)[0]
        recorder.bound(
            f"{label}: order in a/r of what reflections add", -slope, least=2.9,
            source="the strain of one sphere's flow at the other, at least (a/r)³",
        )  # fmt: skip
    recorder.figure("reflections", _figure(table), "The table, and (a/r)³.")


def _figure(table: Array) -> Figure:
    figure = Figure(figsize=(4.4, 3.4))
    axes = figure.subplots()
    for column, label in enumerate(LABELS, start=1):
        axes.loglog(table[:, 0], table[:, column], marker=MARKERS[column - 1], mfc="white",
                    color=SHADES[(column - 1) % len(SHADES)], label=label)  # fmt: skip
    axes.loglog(table[:, 0], table[:, 0] ** -3.0, ":", color="0.5", label="(a/r)³")
    axes.set(xlabel="r/a", ylabel="part of the flow left out")
    axes.legend()
    return figure


def _tree(recorder: Recorder) -> None:
    """Direct sum and tree on the points of a plane through a bent chain."""
    rows: list[list[str]] = []
    worst, times = 0.0, []
    for spheres, points in SIZES[: 2 if recorder.quick else None]:
        near = {"friction": "one-body", "slip.neighbours": 1}
        scene = nrchain.load_scene(crooked(particles=spheres), **near)
        grid = _plane(scene, points)
        tree, found = _timed(scene, grid, accuracy=1e-8)
        times.append((spheres + len(grid), tree))
        entry = [f"{spheres:,}", f"{len(grid):,}", f"{tree:.2f} s", "–", "–", "–"]
        if spheres * len(grid) <= MOST_DIRECT:
            direct, expected = _timed(scene, grid, accuracy=0.0)
            error, size = np.nanmax(np.abs(found - expected)), np.abs(expected)
            worst = max(worst, float(error / np.nanmax(size)))
            shares = error / np.nanmax(size), error / np.nanmedian(size)
            entry[3:] = [f"{direct:.2f} s", *(f"{share:.1e}" for share in shares)]
        rows.append(entry)
    recorder.bound("error of the tree over the largest flow", worst, most=1e-8, source="direct sum")
    recorder.table(
        "The flow of long chains",
        ["Spheres", "Points", "nrchain.flow", "Direct sum", "Error/largest", "Error/median"],
        rows,
        "All modes, forces and torques of a bent chain, at the points of a plane through it: time "
        "of the processor. Below 5e7 pairs the flow is a direct sum; above, a tree sums, and its "
        "largest error is given over the largest and over the median flow.",
        first_page=True,
    )
    if len(times) > 2:
        sizes, seconds = np.array(times[1:]).T
        recorder.bound(
            "order of the time in spheres and points together",
            float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0]),
            most=1.3,
            source="near-linear",
        )


def _plane(scene: nrchain.Scene, points: int) -> Array:
    """About so many points of a plane along the chain, 8 times as long as wide."""
    rows = max(int(np.sqrt(points / 8)), 2)
    half = scene.length / 16
    x, y = np.meshgrid(np.linspace(0.0, scene.length, 8 * rows), np.linspace(-half, half, rows))
    return np.stack([x, y, 0.0 * x], axis=-1).reshape(-1, 3)


def _timed(scene: nrchain.Scene, points: Array, accuracy: float) -> tuple[float, Array]:
    """Seconds of the processor, the least of three, and the velocity."""
    seconds = []
    for _ in range(3):
        begin = time.process_time()
        found = nrchain.flow(
            scene, points, parts=("slip", "forces", "torques"), accuracy=accuracy
        ).velocity
        seconds.append(time.process_time() - begin)
    return min(seconds), found


def _relative(found: Array, expected: Array) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())
