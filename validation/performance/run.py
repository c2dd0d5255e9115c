"""How fast is nrchain, against common practice, and how does it scale with N?

Everything is measured in one run on one machine. Rivals take turns, numbers are medians, and runs
are compared at equal measured error, each side at the loosest tolerance that meets it. Sums over
all pairs are timed with one thread per side, so that other programs do not matter; times with all
threads are recorded beside them. The targets are the project's own; those that are missed are
marked. Today's practice is the recipe of :mod:`validation.performance.recipe`: SciPy's BDF with a
dense difference Jacobian, PyStokes for every pair interaction, and a potential vectorised with
NumPy.
"""

from __future__ import annotations

from validation.performance import (
    effects_left_out,
    elimination,
    ensembles,
    equal_error,
    growth,
    long_chains,
    pair_sums,
    roofline,
    spinning,
    start_up,
)
from validation.report.recorder import Recorder


def study(recorder: Recorder) -> None:
    recorder.step("pair sums against PyStokes")
    recorder.text(
        "PyStokes is compiled with -O1, as the README's line sets it up. On one thread its slip of "
        "2s and 4a and its friction take up to 5 % less time with -O3 (N = 400)."
    )
    pair_sums.compare(recorder)
    recorder.step("nearest neighbours at equal error")
    equal_error.near(recorder)
    recorder.step("long range at equal error")
    equal_error.far(recorder)
    recorder.text(
        "The recipe runs twice: plain, with SciPy's difference Jacobian and the default threads of "
        "every library, and with care. With care means one thread and difference steps of one "
        "size. Two threads that wait for each other are ten times slower in PyStokes on two "
        "spheres, and much slower in SciPy's dense factorisation. SciPy's own difference steps are "
        "lost in rounding where a coordinate is zero. SciPy's BDF then asks for few Jacobians, and "
        "most of its cost is the 6N right-hand sides of each."
    )
    recorder.step("effects left out")
    effects_left_out.compare(recorder)
    recorder.step("Newton matrices")
    elimination.compare(recorder)
    recorder.step("arithmetic and the rest of a run")
    roofline.compare(recorder)
    recorder.step("spinning chains")
    spinning.compare(recorder)
    recorder.step("ensembles")
    ensembles.compare(recorder)
    recorder.step("cost against N")
    growth.cost(recorder)
    recorder.step("long chains")
    long_chains.compare(recorder)
    recorder.step("memory")
    growth.memory(recorder)
    recorder.step("start-up")
    start_up.compare(recorder)
