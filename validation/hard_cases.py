"""Do hard cases stay stable, and does what cannot go on stop well?

A gallery of scenes at the edges of what can be simulated. Each must end as stated: completed,
refused before it starts, or stopped for a cause. What completes is measured: frames stay
orthonormal, a second integrator agrees, a chain moved as a whole moves alike, a passive chain
loses energy; the source of each is the invariance itself.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from nrchain import SceneError, Trajectory, elastic_energy, load_scene, simulate
from nrchain.regime import warnings
from nrchain.start import starting_poses
from validation.hard_fuzz import fuzz
from validation.hard_gallery import GALLERY, REFUSED, Case
from validation.hard_processes import digests, kills_resumed, unwritable
from validation.recorder import Recorder

AGREEMENT = 3e-4
"""Allowed between two integrators at tolerances of 1e-7, in radii, over what the chain moved."""

ORTHONORMAL = 1e-12


def study(recorder: Recorder) -> None:
    rows = []
    for case in GALLERY:
        if case.quick or not recorder.quick:
            recorder.step(case.name)
            rows.append(_judge(recorder, case))
    columns = ["case", "expected", "outcome", "t", "steps", "frames off", "integrators", "s"]
    recorder.table(
        "gallery",
        columns,
        rows,
        "Every case, how it may end and how it did; frames: largest error of orthonormality; "
        "integrators: CVODE against Radau at the end, in a.",
        first_page=True,
    )
    _invariances(recorder)
    _processes(recorder)
    _fuzz(recorder)


def _run(case: Case, **more: object) -> Trajectory | SceneError:
    try:
        scene = case.scene(**more)
        return simulate(scene, **case.poses(scene))
    except SceneError as error:
        return error


def _judge(recorder: Recorder, case: Case) -> list[object]:
    began = time.perf_counter()
    found = _run(case)
    seconds = time.perf_counter() - began
    expected = " or ".join(case.ends)
    if isinstance(found, SceneError):
        _came(recorder, case, REFUSED, str(found))
        return [case.name, expected, REFUSED, None, None, None, None, round(seconds, 2)]
    outcome = found.status if found.cause is None else str(found.cause)
    _came(recorder, case, outcome, found.reason)
    off = _frames_off(found)
    recorder.bound(f"{case.name}: frames orthonormal", off, most=ORTHONORMAL, source="R Rᵀ = 1")
    apart = None
    if case.compare and outcome == "completed":
        other = _run(case, **{"run.integrator": "radau"})
        assert isinstance(other, Trajectory)
        apart = _apart(found, other)
        recorder.bound(
            f"{case.name}: CVODE and Radau IIA", apart, most=AGREEMENT, source="two schemes"
        )
    return [
        *(case.name, expected, outcome, float(found.time[-1]), found.counters["steps"]),
        *(off, apart, round(seconds, 2)),
    ]


def _came(recorder: Recorder, case: Case, outcome: str, reason: str) -> None:
    recorder.bound(
        f"{case.name}: ends as {' or '.join(case.ends)}",
        float(outcome in case.ends),
        least=1.0,
        source=reason or outcome,
    )


def _frames_off(found: Trajectory) -> float:
    gram = np.einsum("...ak,...bk->...ab", found.frames, found.frames)
    return float(np.abs(gram - np.eye(3)).max())


def _apart(one: Trajectory, other: Trajectory) -> float:
    """The largest distance at the end, over what the chain moved where that is more than a."""
    if other.status != one.status:
        return np.inf
    moved = np.abs(one.positions[-1] - one.positions[0]).max() / one.scene.chain.radius
    apart = np.abs(one.positions[-1] - other.positions[-1]).max() / one.scene.chain.radius
    return float(apart / max(moved, 1.0))


def _invariances(recorder: Recorder) -> None:
    recorder.step("rigid motions and energy")
    scene = load_scene("buckling", **{"chain.ends": "free", "run.end": 100.0, "run.snapshots": 5})
    positions, frames = starting_poses(scene)
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    here = simulate(scene)
    there = simulate(scene, positions=positions @ turn.T + 7.0, frames=frames @ turn.T)
    recorder.bound(
        "a chain moved as a whole moves alike",
        np.abs(here.positions[-1] @ turn.T + 7.0 - there.positions[-1]).max(),
        most=AGREEMENT,
        source="no direction is preferred",
    )
    passive = load_scene("passive", **{"chain.ends": "free", "start.amplitude": 1.0})
    run = simulate(passive)
    moduli = passive.moduli._asdict()
    energies = [
        elastic_energy(*poses, spacing=passive.chain.spacing, **moduli)
        for poses in zip(run.positions, run.frames, strict=True)
    ]
    recorder.bound(
        "energy of the passive chain: largest gain between snapshots, over the first",
        float(np.diff(energies).max() / energies[0]),
        most=1e-9,
        source="v = F/γ_T loses energy",
    )
    torn = next(case for case in GALLERY if case.name.startswith("torn: "))
    announced = any("beam limit" in text for text in warnings(torn.scene()))
    recorder.bound("the torn chain is announced", float(announced), least=1.0, source="plan")


def _processes(recorder: Recorder) -> None:
    far = {"chain.particles": 160, "slip.neighbours": "all", "elasticity.ratio": 1e12}
    scene = load_scene("buckling", **far, **{"run.end": 20.0, "run.snapshots": 3})
    recorder.step("threads")
    numbers = (1, 2) if recorder.quick else (1, 2, 4, 8)
    recorder.bound(
        f"results with {', '.join(map(str, numbers))} threads",
        len(digests(scene, numbers)),
        most=1,
        source="each row is written by one iteration",
    )
    with tempfile.TemporaryDirectory() as place:
        times = 2 if recorder.quick else 20
        recorder.step(f"{times} runs killed")
        killed, agreed = kills_resumed(Path(place), times)
        recorder.check("killed runs that end in the same bits", times, agreed, 0.0, source="resume")
        recorder.bound("runs that a kill caught", killed, least=0.5 * times, source="SIGKILL")
        recorder.step("nowhere to write")
        for name, told in unwritable(Path(place)).items():
            whole = bool(told) and "Traceback" not in told
            recorder.bound(f"{name}: one line", float(whole), least=1.0, source=told)


def _fuzz(recorder: Recorder) -> None:
    count = 200 if recorder.quick else 10_000
    recorder.step(f"{count} fuzzed scenes")
    fates, undocumented = fuzz(count)
    recorder.table("fuzz", ["how it ended", "scenes"], fates.most_common(), "Fuzzed scene files.")
    recorder.bound(
        f"undocumented errors in {count} fuzzed scenes",
        len(undocumented),
        most=0,
        source="; ".join(undocumented[:3]) or "every refusal is an NrchainError",
    )
