"""Newton matrices I − cJ of near neighbours: elimination by blocks against LAPACK."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import lapack

from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from validation.performance.scenes import PROJECT, curved
from validation.performance.timing import in_turns
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

STEP = 0.5
"""|c| in units of the time in which a bond relaxes."""


def compare(recorder: Recorder) -> None:
    """Record the time of factors and of a solve; LAPACK is given its band ready."""
    for count in (20, 64) if recorder.quick else (20, 64, 1000):
        chain = ChartedChain(Model(curved(count)))
        chain.rebase(0.0, *initial_poses(curved(count)))
        chain.linearise(0.0, np.zeros(chain.dimension))
        for kind, scale in (("real", STEP), ("complex", STEP * (0.6 + 0.8j))):
            ours, theirs = _tasks(chain, scale)
            with one_thread():
                times = in_turns(
                    {
                        f"{who} {part}": task[part]
                        for part in ours
                        for who, task in (("our", ours), ("their", theirs))
                    },
                    rounds=5 if recorder.quick else 25,
                )
            for part in ours:
                our, their = (float(np.median(times[f"{who} {part}"])) for who in ("our", "their"))
                what = f"{part}, {kind}, N = {count}, couplings to three neighbours"
                recorder.benchmark(f"elimination, {what}", our, their, what=what)
                if count == 64 and part == "factors":
                    recorder.bound(
                        f"{what}: times LAPACK's speed", their / our, least=1.5, source=PROJECT
                    )


Tasks = dict[str, Callable[[], object]]


def _tasks(chain: ChartedChain, scale: complex) -> tuple[Tasks, Tasks]:
    """Our factors and solve, and those of LAPACK."""
    right = np.ones(chain.dimension, type(scale))
    out, half = np.empty_like(right), 6 * chain.model.reach + 5
    jacobian = chain.near_jacobian().tocoo()
    band = np.zeros((3 * half + 1, chain.dimension), right.dtype, order="F")
    band[2 * half] = 1.0
    band[2 * half + jacobian.row - jacobian.col, jacobian.col] -= scale * jacobian.data
    gbtrf, gbtrs = lapack.get_lapack_funcs(("gbtrf", "gbtrs"), (band,))
    factors, pivots, _ = gbtrf(band, half, half)
    chain.factorise(scale)
    ours: Tasks = {
        "factors": lambda: chain.factorise(scale),
        "a solve": lambda: chain.solve(right, out),
    }
    theirs: Tasks = {
        "factors": lambda: gbtrf(band, half, half),
        "a solve": lambda: gbtrs(factors, half, half, right, pivots),
    }
    return ours, theirs
