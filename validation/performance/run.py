"""How fast is it, against today's practice and against itself, and what grows with N?

Everything is measured in one run on one machine: rivals take turns with what they are compared
with, numbers are medians, and runs are compared at equal measured error, each side at the loosest
tolerance that meets it. Sums over all pairs are timed with one thread a side, so that neither waits
for what else the machine does; what all threads make of it is recorded beside it. The bars are the
project's own, and those that are missed are stated as such. Today's practice is the recipe of
:mod:`validation.performance.recipe`: SciPy's BDF with a dense difference Jacobian, PyStokes for
every pair interaction, and a potential vectorised with NumPy.
"""

from __future__ import annotations

from validation.performance import effects_left_out, equal_error, growth, pair_sums, spinning
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
        "The recipe is run as it is written down, with SciPy's own difference Jacobian and the "
        "threads that every library takes by itself, and once more with care. Care is one thread "
        "(two that wait for each other are ten times slower in PyStokes when it is shown two "
        "spheres at a time, and much slower in SciPy's dense factorisation) and difference steps "
        "of one size (SciPy's own are lost in rounding where a coordinate is zero). SciPy's BDF "
        "then asks for few Jacobians, and most of its cost is that of 6N right-hand sides for "
        "each of them."
    )
    recorder.step("effects left out")
    effects_left_out.compare(recorder)
    recorder.step("spinning chains")
    spinning.compare(recorder)
    recorder.step("cost against N")
    growth.cost(recorder)
    recorder.step("memory")
    growth.memory(recorder)
    recorder.step("start-up")
    growth.start(recorder)
