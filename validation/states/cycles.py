"""Cycles of chains of 2s and 3t, and of a free chain that swims in strokes, against runs.

A clamped chain of pushers with 3t and links of the paper's measure goes round on paths like
ellipses. Runs approach them slowly: at 3t = 1000 a small change decays by 0.865 in a period, so
that paths that differ a little, long after the start, are one cycle. A family of cycles would have
a further multiplier 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import nrchain
from validation.report.recorder import Recorder

PUSHERS = {"slip.2s": 60.0, "slip.3t": 1000.0, "elasticity.ratio": 1e8, "start.amplitude": 0.5}

SHORT = {"chain.particles": 12, "slip.2s": 200.0, "slip.3t": 11500.0, "elasticity.ratio": 1e8}
"""A chain whose cycle loses stability to a pair of multipliers."""

STROKES = {
    "chain.particles": 7,
    "chain.ends": "free",
    "elasticity.ratio": 1e7,
    "slip.neighbours": "all",
    "slip.2s": [800.0, -1200.0, -400.0, 100.0, -1000.0, 800.0, -900.0],
    "slip.4a": [0.0, 300.0, -1500.0, -700.0, -800.0, 1300.0, -600.0],
    "start.amplitude": 0.3,
    "run.end": 100.0,
    "run.snapshots": 201,
}
"""A free chain of given strengths that changes its shape as it swims."""

TIGHT = {"run.rtol": 1e-10, "run.atol": 1e-10, "run.integrator": "radau"}

WITHIN = 1e-2
"""Of multipliers, and of what runs off a cycle grow by."""

SAME = 1e-6
"""Of periods by two ways, relative."""

SQUARE_ROOT = 0.03
"""Of the exponent of amplitudes near a threshold and 1/2."""

Row = tuple[str | int | float, ...]


def cycles(recorder: Recorder) -> None:
    """All cycles, and a table of them."""
    recorder.step("cycles: pushers with 3t")
    rows = [_pushers(recorder)]
    recorder.step("cycles: a free chain")
    rows.append(_strokes(recorder))
    recorder.step("cycles: from their onset")
    _onset(recorder)
    if not recorder.quick:
        recorder.step("cycles: where one loses stability")
        _lost(recorder)
    recorder.table(
        "Cycles",
        ["Chain", "N", "Period", "Error", "Amplitude", "Largest |μ|", "Carried", "Turned (rad)"],
        rows,
        "Period with its error, the largest distance of a sphere from its mean position, the "
        "largest Floquet multiplier beside the trivial ones, and by how far a period carries and "
        "turns the chain as a whole.",
    )


def _pushers(recorder: Recorder) -> Row:
    """Several starts lead to one cycle, which attracts them at the rate of its multipliers."""
    found = []
    for seed in (0, 1):
        changes = {"start.seed": seed, "run.end": 9000.0, "run.snapshots": 1801}
        scene = nrchain.load_scene("buckling", **PUSHERS | changes)
        found.append(nrchain.find_cycle(scene, nrchain.simulate(scene), tolerance=1e-7))
    cycle, other = found
    recorder.check(
        "2s + 3t: period from one random start over that from another",
        1.0,
        other.period / cycle.period,
        SAME,
        source="a cycle that is no member of a family",
    )
    recorder.bound(
        "2s + 3t: largest |μ|",
        float(np.abs(cycle.multipliers).max()),
        most=0.9,
        source="a family of cycles has a further multiplier 1",
    )
    recorder.bound(
        "2s + 3t: distance of the multiplier along the path from 1",
        cycle.trivial.error,
        most=1e-6,
        source="a shift in time",
    )
    _against_a_run(recorder, "2s + 3t", cycle)
    _growth(recorder, "2s + 3t", cycle)
    return _row("2s + 3t, clamped", cycle)


def _strokes(recorder: Recorder) -> Row:
    scene = nrchain.load_scene("buckling", **STROKES)
    cycle = nrchain.find_cycle(scene, nrchain.simulate(scene))
    _against_a_run(recorder, "2s + 4a, free", cycle)
    _growth(recorder, "2s + 4a, free", cycle)
    recorder.bound(
        "2s + 4a, free: distance of trivial multipliers from 1 and exp(±iΩT)",
        cycle.trivial.error,
        most=1e-5,
        source="time, translations and rotations",
    )
    return _row("2s + 4a, free, all pairs", cycle)


def _against_a_run(recorder: Recorder, name: str, cycle: nrchain.Cycle) -> None:
    """A run from the cycle comes back after the period, carried and turned."""
    run = _run(cycle, cycle.at(0.0), cycle.period, 2)
    positions, frames = cycle.at(cycle.period)
    away = max(np.abs(run.positions[-1] - positions).max(), np.abs(run.frames[-1] - frames).max())
    recorder.bound(
        f"simulated: {name}, distance from the cycle after a period, over its error",
        float(away) / cycle.error,
        most=2.0,
        source="a run with Radau at 1e-10",
    )


def _growth(recorder: Recorder, name: str, cycle: nrchain.Cycle) -> None:
    """Small changes along the leading mode grow by μ in a period."""
    recorder.check(
        f"simulated: {name}, growth of a small change in a period over μ",
        1.0,
        float(abs(_measured(cycle) / cycle.multipliers[0])),
        WITHIN,
        source="a run that starts off the cycle along its leading mode",
    )


def _measured(cycle: nrchain.Cycle) -> complex:
    """μ of the leading mode, of a run that starts off the cycle: its part of what has grown."""
    start, mode, size = cycle.at(0.0), cycle.modes[0], 1e-4
    ends = [_end(cycle, _moved(start, sign * size * mode.real)) for sign in (1.0, -1.0)]
    columns = np.stack([mode.real, mode.imag, *_neutral(cycle)], axis=-1)
    slope = (ends[0] - ends[1]) / (2.0 * size)
    parts = np.linalg.lstsq(columns.reshape(-1, columns.shape[-1]), slope.ravel(), rcond=None)[0]
    return complex(parts[0], -parts[1]) if np.iscomplex(cycle.multipliers[0]) else complex(parts[0])


def _end(cycle: nrchain.Cycle, begin: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(N, 6): displacement and rotation from the cycle after a period, in axes that go along."""
    run = _run(cycle, begin, cycle.period, 2)
    positions, frames = cycle.at(cycle.period)
    back = np.einsum("naj,nak->jk", cycle.at(0.0)[1], frames) / len(frames)
    u, _, v = np.linalg.svd(back)
    turn = u @ v
    shift = (run.positions[-1] - positions) @ turn.T
    turned = _rotation(run.frames[-1], frames) @ turn.T
    return np.hstack([shift, turned])


def _rotation(frames: np.ndarray, before: np.ndarray) -> np.ndarray:
    """(N, 3): small rotations from frames before."""
    turned = np.einsum("nai,nak->nik", frames, before)
    pairs = ((2, 1), (0, 2), (1, 0))
    return 0.5 * np.stack([turned[:, i, k] - turned[:, k, i] for i, k in pairs], axis=-1)


def _neutral(cycle: nrchain.Cycle) -> Sequence[np.ndarray]:
    """(N, 6) each: along the path, and motions of a free chain as a whole."""
    positions, frames = cycle.at(0.0)
    step = 1e-4 * cycle.period
    run = _run(cycle, (positions, frames), step, 2)
    rotation = _rotation(run.frames[-1], frames)
    found = [np.hstack([run.positions[-1] - positions, rotation]) / step]
    if cycle.scene.chain.ends == "free":
        for unit in np.eye(3):
            still = np.zeros_like(positions)
            found.append(np.hstack([still + unit, still]))
            found.append(np.hstack([np.cross(unit, positions - cycle.origin), still + unit]))
    return found


def _moved(
    poses: tuple[np.ndarray, np.ndarray], change: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses displaced and rotated by a small change (N, 6)."""
    positions, frames = poses
    rows = frames + np.cross(change[:, None, 3:], frames)
    # the nearest rotations
    u, _, v = np.linalg.svd(rows)
    return positions + change[:, :3], u @ v


def _run(
    cycle: nrchain.Cycle, begin: tuple[np.ndarray, np.ndarray], end: float, snapshots: int
) -> nrchain.Trajectory:
    times = {"run.end": end, "run.snapshots": snapshots}
    scene = nrchain.load_scene(cycle.scene, **TIGHT | times)
    return nrchain.simulate(scene, positions=begin[0], frames=begin[1])


def _onset(recorder: Recorder) -> None:
    """Two kinds of oscillation leave the Hopf point of the straight chain."""
    scene = nrchain.load_scene("buckling", **PUSHERS | {"slip.3t": 700.0})
    along = {"slip.3t": (700.0, 1000.0)}
    found = nrchain.continue_state(scene, along, branches=1)
    (onset,) = [point for point in found.special if point.kind == "Hopf"]
    branches = nrchain.continue_cycle(
        scene, along, onset, steps=6, step=0.05, intervals=24
    ).branches
    recorder.check(
        "2s + 3t: branches of cycles that leave the Hopf point",
        2,
        len(branches),
        0.0,
        source="the symmetry of a chain whose links tell y from z: to and fro, and around",
    )
    for branch in branches:
        kind = "around" if branch.is_stable[-1] else "to and fro"
        beyond = branch.values[:4] - onset.value
        slope = np.polyfit(np.log(beyond), np.log(branch.amplitudes[:4]), 1)[0]
        recorder.check(
            f"2s + 3t, {kind}: exponent of the amplitude",
            0.5,
            slope,
            SQUARE_ROOT,
            source="a Hopf point",
        )
        limit = np.polyfit(beyond, branch.periods[:4], 2)[-1]
        recorder.check(
            f"2s + 3t, {kind}: period at the onset over 2π/ω of the mode",
            1.0,
            limit * onset.frequency / (2.0 * np.pi),
            1e-3,
            source="Im Λ of the straight chain",
        )
    recorder.check(
        "2s + 3t: branches of cycles that are stable at the onset",
        1,
        sum(bool(branch.is_stable[0]) for branch in branches),
        0.0,
        source="runs, which go round",
    )


def _lost(recorder: Recorder) -> None:
    """Runs off a cycle decay before a Neimark–Sacker point, and grow beyond."""
    scene = nrchain.load_scene("buckling", **SHORT)
    run = nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 1500.0, "run.snapshots": 1501}))
    along = {"slip.3t": (11400.0, 12080.0)}
    found = nrchain.continue_cycle(scene, along, run, step=0.1, intervals=32)
    (special,) = found.special
    (branch,) = found.branches
    recorder.text(
        f"A chain of 12 with 2s = 200 goes round on one path up to 3t = {special.value:.6g}. There "
        f"a pair of multipliers leaves the unit circle at ±{special.angle:.3f} rad "
        f"({special.kind})."
    )
    for side, place in (("before", special.index), ("beyond", special.index + 1)):
        cycle = branch.cycle(place, tolerance=1e-5)
        _growth(recorder, f"{side} the {special.kind} point", cycle)


def _row(name: str, cycle: nrchain.Cycle) -> Row:
    return (
        *(name, cycle.scene.chain.particles, round(cycle.period, 5), f"{cycle.period_error:.1e}"),
        *(round(cycle.amplitude, 4), round(float(np.abs(cycle.multipliers).max()), 4)),
        round(float(np.linalg.norm(cycle.displacement)), 4),
        round(float(np.linalg.norm(cycle.rotation_angle)), 4),
    )
