"""Do hard cases stay stable, and do runs that cannot continue stop with a clear message?

A gallery of scenes at the limits of the simulation. Each must end as stated: completed, refused
before the start, or stopped for a cause. Completed runs are checked: frames stay orthonormal, a
second integrator agrees within its tolerance, a rigid motion of the start moves the run along, and
a passive chain loses energy. The source of each check is the invariance itself.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from nrchain import Cause, SceneError, Trajectory, elastic_energy, load_scene, regime, simulate
from nrchain.planning.integrator import integrator_of
from validation.hard_cases import charts, costs, processes
from validation.hard_cases.agreement import LEEWAY, Agreement, agreement, nudge
from validation.hard_cases.fuzz import NOT_RUN, fuzz
from validation.hard_cases.outputs import GOES_ON, NOT_TRIED
from validation.report.gallery import COMPLETED, GALLERY, REFUSED, Case
from validation.report.recorder import Recorder

ORTHONORMAL = 1e-12

GROWN = 1024
"""Largest growth of peak memory, in kB, over the last nine tenths of a run."""


def study(recorder: Recorder) -> None:
    rows = []
    for case in GALLERY:
        if case.quick or not recorder.quick:
            recorder.step(case.name)
            rows.append(_judge(recorder, case))
    recorder.table(
        "gallery",
        [
            *("case", "expected", "outcome", "t", "steps", "frames off"),
            *("second", "apart", "growth", "apart / tolerance", "allowed", "s"),
        ],
        rows,
        "Every case, its allowed ends and its end. Frames: largest error of orthonormality. "
        "Apart: its integrator and a second one at the end, in a or rad. Tolerance: atol + rtol "
        f"times the largest displacement. Allowed: {LEEWAY:g} times the growth of a small "
        "separation. Seconds are those of the first run.",
        first_page=True,
    )
    _invariances(recorder)
    _charts(recorder)
    _processes(recorder)
    _watching(recorder)
    _fuzz(recorder)


def _run(case: Case, **more: Any) -> Trajectory | SceneError:
    try:
        scene = case.scene(**more)
        return simulate(scene, **case.poses(scene))
    except SceneError as error:
        return error


def _judge(recorder: Recorder, case: Case) -> list[object]:
    began = time.perf_counter()
    found = _run(case)
    seconds = round(time.perf_counter() - began, 2)
    expected = " or ".join(case.ends)
    if isinstance(found, SceneError):
        _came(recorder, case, REFUSED, str(found))
        return [case.name, expected, REFUSED, *[None] * 8, seconds]
    outcome = found.status if found.cause is None else str(found.cause)
    _came(recorder, case, outcome, found.reason)
    off = _frames_off(found)
    recorder.bound(f"{case.name}: frames orthonormal", off, most=ORTHONORMAL, source="R Rᵀ = 1")
    reached = [float(found.time[-1]), found.counters["steps"], off]
    if outcome != COMPLETED:
        return [case.name, expected, outcome, *reached, *[None] * 5, seconds]
    near = _compare(recorder, case, found)
    agreed = [_schemes(case)[1], near.apart, near.growth, near.factor, near.allowed]
    return [case.name, expected, outcome, *reached, *agreed, seconds]


def _came(recorder: Recorder, case: Case, outcome: str, reason: str) -> None:
    recorder.bound(
        f"{case.name}: ends as {' or '.join(case.ends)}",
        float(outcome in case.ends),
        least=1.0,
        source=reason or outcome,
    )


def _compare(recorder: Recorder, case: Case, found: Trajectory) -> Agreement:
    first, second = _schemes(case)
    other = _run(case, **{"run.integrator": second})
    assert isinstance(other, Trajectory)
    near = agreement(found, other, simulate(case.scene(), **nudge(case)))
    recorder.bound(
        f"{case.name}: {first} and {second}, in tolerances",
        near.factor,
        most=near.allowed,
        source=f"two schemes; {LEEWAY:g} times a growth of {near.growth:.3g}",
    )
    return near


def _schemes(case: Case) -> tuple[str, str]:
    """The integrator of a case, and the one that it is compared with."""
    scene = case.scene()
    first = integrator_of(scene)
    return first, case.second or ("cvode" if first == "radau" else "radau")


def _frames_off(found: Trajectory) -> float:
    gram = np.einsum("...ak,...bk->...ab", found.frames, found.frames)
    return float(np.abs(gram - np.eye(3)).max())


def _invariances(recorder: Recorder) -> None:
    recorder.step("rigid motions and energy")
    changes = {"chain.ends": "free", "run.end": 100.0, "run.snapshots": 5}
    case = Case("moved as a whole", "buckling", changes)
    scene = case.scene()
    positions, frames = case.start(scene)
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    here = simulate(scene)
    moved = simulate(scene, positions=positions @ turn.T + 7.0, frames=frames @ turn.T)
    back = Trajectory(moved.time, (moved.positions - 7.0) @ turn, moved.frames @ turn, scene)
    near = agreement(here, back, simulate(scene, **nudge(case)))
    recorder.bound(
        "a chain moved as a whole moves alike, in tolerances",
        near.factor,
        most=near.allowed,
        source=f"no direction is preferred; {LEEWAY:g} times a growth of {near.growth:.3g}",
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
    announced = any("beam limit" in text for text in regime.warnings(torn.scene()))
    recorder.bound("the torn chain is announced", float(announced), least=1.0, source="plan")


def _charts(recorder: Recorder) -> None:
    recorder.step("turns of 10⁴ rad, charts at their half turn")
    for name in ("cvode", "radau"):
        turn = charts.spin(name)
        recorder.bound(
            f"rad turned through, {name}",
            abs(turn.counted),
            least=charts.FAR,
            source="summed from snapshot to snapshot",
        )
        recorder.check(
            f"mean angle against (1 − 1/N) Ω₀ t, {name}",
            turn.exact,
            turn.counted,
            LEEWAY * turn.tolerance,
            source="a straight chain turns steadily",
            relative=False,
        )
    frames, twists = charts.chart_near_its_half_turn()
    recorder.bound(
        "frames of a chart π − 1e-9 from its base", frames, most=1e-14, source="poses given"
    )
    recorder.bound(
        "twists by the rates of a chart π − 1e-9 from its base, over those at its base",
        twists,
        most=1e-12,
        source="ω is the same in every chart",
    )
    cause = charts.leap(load_scene("buckling", **{"chain.ends": "free", "run.end": 100.0}))
    recorder.bound(
        "a step to π − 1e-9 from the base stops the run",
        float(cause is Cause.CHART),
        least=1.0,
        source=str(cause),
    )


def _processes(recorder: Recorder) -> None:
    far = {"chain.particles": 160, "slip.neighbours": "all", "elasticity.ratio": 1e12}
    scene = load_scene("buckling", **far, **{"run.end": 20.0, "run.snapshots": 3})
    recorder.step("threads")
    numbers = (1, 2) if recorder.quick else (1, 2, 4, 8)
    recorder.bound(
        f"results with {', '.join(map(str, numbers))} threads",
        len(processes.digests(scene, numbers)),
        most=1,
        source="each row is written by one iteration",
    )
    with tempfile.TemporaryDirectory() as place:
        _kills(recorder, Path(place))
        if not recorder.quick:
            _soak(recorder, Path(place))
    _outputs(recorder)


def _kills(recorder: Recorder, place: Path) -> None:
    times = 4 if recorder.quick else 20
    recorder.step(f"{times} runs killed")
    kills = processes.kills_resumed(place, times)
    recorder.table(
        "kills",
        ["killed", "left", "snapshots", "resumed from t", "same bits"],
        [[one.when, one.status, one.snapshots, one.begin, one.agreed] for one in kills],
        "Runs killed by SIGKILL and resumed. A run without a checkpoint starts again.",
    )
    agreed = sum(one.agreed for one in kills)
    recorder.check("killed runs that end in the same bits", times, agreed, 0.0, source="resume")
    caught = sum(one.status == "running" for one in kills)
    recorder.bound("runs that a kill caught", caught, least=0.75 * times, source="SIGKILL")


def _outputs(recorder: Recorder) -> None:
    recorder.step("nowhere to write")
    answers = processes.outputs()
    recorder.table("outputs", ["Fault", "Message"], answers.items(), "Outputs and inputs.")
    for name, message in answers.items():
        if message == NOT_TRIED:
            continue
        fine = message == COMPLETED if name in GOES_ON else "\n" not in message and ": " in message
        recorder.bound(f"{name}: ends well", float(fine), least=1.0, source=message)


def _soak(recorder: Recorder, place: Path) -> None:
    steps = 100_000
    recorder.step(f"{steps} steps")
    found = processes.soak(place, steps)
    recorder.check("steps of the long run", steps, found["steps"], 0.0, source="run.max_steps")
    recorder.bound(
        "kB that memory grew by in its last nine tenths",
        found["grown"],
        most=GROWN,
        source=f"peak {found['peak']} kB",
    )


def _watching(recorder: Recorder) -> None:
    recorder.step("the cost of watching")
    for name, scene in costs.scenes(recorder.quick).items():
        guarded, blind = costs.watching(scene)
        recorder.benchmark(
            f"watching for contacts and quarter turns, {name}",
            guarded,
            blind,
            what="a run with the guard, and one with the guard switched off",
        )


def _fuzz(recorder: Recorder) -> None:
    count = 200 if recorder.quick else 10_000
    recorder.step(f"{count} fuzzed scenes")
    fates, undocumented = fuzz(count)
    ends = sorted({end for counter in fates.values() for end in counter})
    recorder.table(
        "fuzz",
        ["how it ended", *fates],
        [[end, *(counter[end] for counter in fates.values())] for end in ends],
        "Fuzzed scenes: texts with changed lines and characters, tables of allowed values.",
    )
    ran = count - len(undocumented)
    ran -= sum(counter[end] for counter in fates.values() for end in (REFUSED, NOT_RUN))
    recorder.bound("share of fuzzed scenes that ran", ran / count, least=0.3, source="not refused")
    recorder.bound(
        f"undocumented errors in {count} fuzzed scenes",
        len(undocumented),
        most=0,
        source="; ".join(undocumented[:3]) or "every refusal is an NrchainError",
    )
