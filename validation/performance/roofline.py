"""A run of near neighbours over the time of its arithmetic: kernels, factors and solves.

The calls that a run makes of each function of its equation are counted, and each function is timed
by itself in compiled code, at the poses where the run ends. What is left of the time of the run is
stepping, charts, the search for contacts, recording and set-up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nrchain import Scene, load_scene, simulate
from nrchain._addresses import Callback, call
from nrchain._compile import kernel
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators import radau_steps as steps
from nrchain.motion.integrators.chain_equation import ChainEquation
from nrchain.motion.integrators.radau import Radau
from nrchain.motion.model import Model
from nrchain.run.preparation import make_integrator
from nrchain.scene.poses import initial_poses
from validation.performance.growth import wavy
from validation.performance.scenes import PROJECT, buckling
from validation.performance.timing import in_turns
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

BAR = 1.3
"""Largest time of a run over that of its arithmetic."""

MISSED = {
    ("buckling, N = 20", "steps"): (1.5, "charts, norms and looks at the steps of a short chain"),
    ("buckling, N = 20", "the whole run"): (2.5, "1.5 to 3 ms of Python, for set-up and recording"),
    ("wavy chain, N = 1000", "steps"): (
        1.4,
        "a new chart in every step, and factors that other data push out of the cache",
    ),
    ("wavy chain, N = 1000", "the whole run"): (
        1.8,
        "new charts, factors out of the cache, and the set-up and check of the start",
    ),
}
"""What was reached where the bar is missed, and why."""

PARTS = {
    steps.RATES: "right-hand sides",
    steps.LINEARISE: "Jacobians",
    steps.FACTORISE: "factors",
    steps.SOLVE_REAL: "real solves",
    steps.SOLVE_PAIR: "complex solves",
}
"""The arithmetic of a run, by the functions of its equation."""


@dataclass(frozen=True)
class Roofline:
    """Calls and seconds of each part of a run, and seconds of its steps and of all of it."""

    calls: Counter[int]
    seconds: dict[int, float]
    steps: float
    run: float

    @property
    def arithmetic(self) -> float:
        """Seconds of all parts together."""
        return sum(self.calls[which] * self.seconds[which] for which in PARTS)


def compare(recorder: Recorder) -> None:
    """Record the time of runs over that of their arithmetic."""
    scenes = {"buckling, N = 20": load_scene("buckling")}
    if not recorder.quick:
        scenes["near run, N = 64"] = buckling(64)
        scenes["wavy chain, N = 1000"] = wavy(1000, 1.0)
    rows = []
    for name, scene in scenes.items():
        with one_thread():
            found = measure(scene, rounds=5 if recorder.quick else 15)
        parts = [1e3 * found.calls[which] * found.seconds[which] for which in PARTS]
        rows.append((name, *parts, 1e3 * found.steps, 1e3 * found.run))
        for what, seconds in (("steps", found.steps), ("the whole run", found.run)):
            title = f"{name}: time of {what} over that of kernels and factors"
            ratio = seconds / found.arithmetic
            if (name, what) in MISSED:
                reached, why = MISSED[name, what]
                recorder.shortfall(title, ratio, asked=BAR, reached=reached, source=why)
            else:
                recorder.bound(title, ratio, most=BAR, source=PROJECT)
    recorder.table(
        "Roofline",
        ["Run", *(f"{part} (ms)" for part in PARTS.values()), "steps (ms)", "run (ms)"],
        rows,
        "Calls of a run times the time of each by itself; one thread, medians of turns. The whole "
        "run has set-up and recording as well.",
    )


def measure(scene: Scene, rounds: int) -> Roofline:
    """Count and time the parts of a run with compiled Radau."""
    calls, equation = _counted(scene)
    taken: list[float] = []

    def run() -> None:
        taken.append(simulate(scene).counters["processor_time"])

    tasks = {str(which): _repeated(equation, which) for which in PARTS}
    times = in_turns({**tasks, "run": run}, rounds=rounds)
    seconds = {which: float(np.median(times[str(which)])) / REPEATS for which in PARTS}
    return Roofline(calls, seconds, float(np.median(taken)), float(np.median(times["run"])))


def _counted(scene: Scene) -> tuple[Counter[int], ChainEquation]:
    """Calls of every function in a run, and the equation at its end."""
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, *initial_poses(scene))
    integrator = make_integrator(scene, chain)
    assert isinstance(integrator, Radau)
    equation, calls = integrator.equation, Counter[int]()
    functions = equation.functions.copy()

    def counting(source: int, target: int, flag: int, which: int) -> int:
        calls[which] += 1
        return equation.call(which, source, target)

    callback = Callback(counting)
    equation.functions[: steps.CONTEXT] = callback.address
    integrator.start(0.0, np.zeros(chain.dimension))
    while integrator.reached < scene.run.end:
        integrator.step()
    equation.functions[:] = functions
    return calls, equation


REPEATS = 20


@kernel
def _repeat(functions, vectors, pair, which, source, target):
    """Call a function of an equation :data:`REPEATS` times with these rows."""
    begin, row, at = vectors.ctypes.data, 8 * vectors.shape[1], pair.ctypes.data
    for _ in range(REPEATS):
        vectors[source] = 1e-3
        pair[:] = 1e-3
        if which != steps.SOLVE_PAIR:
            at = begin + row * source
        call(functions[which], functions[steps.CONTEXT], at, begin + row * target, 0, which)


def _repeated(equation: ChainEquation, which: int) -> Callable[[], object]:
    """A task that calls a function of an equation :data:`REPEATS` times."""
    vectors, pair = equation.vectors.copy(), equation.pair.copy()
    source = steps.REAL_SIDE if which == steps.SOLVE_REAL else steps.STILL
    if which == steps.RATES:
        source = steps.STAGES
    return lambda: _repeat(equation.functions, vectors, pair, which, source, steps.SLOPES)
