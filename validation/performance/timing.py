"""Time tasks in turns and runs at equal error; measure memory in child processes."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain import Scene, Trajectory, load_scene, simulate
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from validation.performance.recipe import Solution

Array = NDArray[np.float64]
Task = Callable[[], object]
Solve = Callable[[Scene, Array, Array, Array, float, float], Solution]

ROOT = Path(__file__).resolve().parents[2]
TOLERANCES = tuple(10.0 ** (-0.5 * k) for k in range(3, 19))
"""rtol = atol of the runs, from loose to tight."""

REFERENCE = 1e-10
"""rtol = atol of the reference runs."""


@dataclass(frozen=True)
class Timed:
    """A run at the loosest tolerance that meets an error: max |r − r′|/a over its snapshots."""

    tolerance: float
    error: float
    seconds: float
    evaluations: int
    jacobians: int


def in_turns(tasks: Mapping[str, Task], *, rounds: int = 15, sample: float = 0.02) -> dict:
    """Seconds per call, (rounds,) by name.

    Tasks take turns, so that other programs on the machine affect all of them alike. Each turn
    calls a task as often as fits into ``sample`` seconds.
    """
    calls = {}
    for name, task in tasks.items():
        task()
        calls[name] = max(1, int(sample / max(min(_seconds(task, 1) for _ in range(3)), 1e-7)))
    found = {name: np.empty(rounds) for name in tasks}
    for turn in range(rounds):
        for name, task in tasks.items():
            found[name][turn] = _seconds(task, calls[name])
    return found


def _seconds(task: Task, calls: int) -> float:
    begin = time.perf_counter()
    for _ in range(calls):
        task()
    return (time.perf_counter() - begin) / calls


def rates_of(scene: Scene) -> Task:
    """One evaluation of the scene's right-hand side, at its start."""
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, *initial_poses(scene))
    y, out = np.zeros(chain.dimension), np.empty(chain.dimension)
    return lambda: chain.rates(0.0, y, out)


def at_tolerance(scene: Scene, tolerance: float, **changes: Any) -> Scene:
    return load_scene(scene, **{"run.rtol": tolerance, "run.atol": tolerance}, **changes)


def reference(scene: Scene) -> Trajectory:
    """The reference run."""
    return simulate(at_tolerance(scene, REFERENCE))


def miss(positions: Array, true: Trajectory) -> float:
    """max |r − r′|/a over spheres and snapshots; infinite for a run that stopped early."""
    if positions.shape != true.positions.shape:
        return math.inf
    apart = np.linalg.norm(positions - true.positions, axis=-1)
    return float(apart.max() / true.scene.chain.radius)


def ours(scene: Scene, tolerance: float, true: Trajectory) -> Timed:
    """Time a run of nrchain."""
    begin = time.perf_counter()
    found = simulate(at_tolerance(scene, tolerance))
    seconds = time.perf_counter() - begin
    evaluations, jacobians = (int(found.counters[key]) for key in ("evaluations", "jacobians"))
    return Timed(tolerance, miss(found.positions, true), seconds, evaluations, jacobians)


def theirs(solve: Solve, scene: Scene, tolerance: float, true: Trajectory) -> Timed:
    """Time a run of a rival; a run that fails has an infinite error."""
    try:
        found = solve(scene, *initial_poses(scene), true.time, tolerance, tolerance)
    except ArithmeticError:
        return Timed(tolerance, math.inf, math.nan, 0, 0)
    error = miss(found.positions, true)
    return Timed(tolerance, error, found.seconds, found.evaluations, found.jacobians)


def loosest(run: Callable[[float], Timed], most: float, first: float = TOLERANCES[0]) -> Timed:
    """The run at the loosest of :data:`TOLERANCES` ≤ ``first`` with an error ≤ ``most``."""
    for tolerance in TOLERANCES:
        if tolerance <= first and (found := run(tolerance)).error <= most:
            return found
    raise ArithmeticError(f"no tolerance down to {TOLERANCES[-1]:.0e} meets an error of {most:g}")


_CHILD = """
import json, sys
from nrchain import load_scene, simulate
counters = simulate(load_scene(json.loads(sys.argv[1]))).counters
lines = open("/proc/self/status").read().splitlines()
peak = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
print(json.dumps({"mebibytes": peak / 1024, **counters}))
"""


def in_child(scene: Scene) -> dict[str, float]:
    """Counters of a run in a process of its own, and its peak resident memory in ``mebibytes``.

    The kernel's high-water mark of the process is Linux's; elsewhere FileNotFoundError is raised.
    """
    command = [sys.executable, "-c", _CHILD, json.dumps(scene.to_mapping())]
    done = subprocess.run(
        command, cwd=ROOT, env=child_environment(), capture_output=True, text=True, check=False
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
        raise ChildProcessError(f"a run of {scene.chain.particles} spheres died: {last}")
    return json.loads(done.stdout)


def child_environment() -> dict[str, str]:
    """That of a process which finds the package and its validation."""
    return dict(os.environ) | {"PYTHONPATH": str(ROOT)}
