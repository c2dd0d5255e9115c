"""Does the nonlinear rod have the motion of the chain, at deflections of the order of L?

From one scene both run from the same smooth curve: a pusher that buckles, 3a that coils, a wave of
3t, a spiral of 4a, and all four. Strengths fall with L so that dimensionless groups stay fixed, and
the distance of chain and rod is measured as d/L → 0. Its order is that of the derivation in
:mod:`nrchain.theory.rod.nonlinear.chain_law`. No constant is fitted.
"""

from __future__ import annotations

import math

from validation.report.recorder import Recorder
from validation.rod import budget, figures, speed
from validation.rod.cases import CASES, Case, distance

SPHERES = (41, 81)
"""The numbers of spheres between which an order is taken."""


def study(recorder: Recorder) -> None:
    recorder.step("order in d/L")
    spheres = (21, 41) if recorder.quick else SPHERES
    rows = [compare(recorder, name, case, spheres) for name, case in CASES.items()]
    recorder.table(
        "distances",
        ("case", f"N = {spheres[0]}", f"N = {spheres[1]}", "order"),
        rows,
        "max |r_chain − r_rod|/L at the end of a run, nearest neighbours.",
    )
    recorder.step("budget")
    budget.compare(recorder)
    recorder.step("speed")
    speed.compare(recorder)
    recorder.step("figure")
    figures.draw(recorder)
    recorder.text(
        "**The rod.** Chain and rod approach each other as (d/L)² in all five cases, with their "
        "ends. Two neighbours feel the strain of the link between them, not that of the rod at its "
        "middle. With this one correction the rate of 3a is that of the chain; linear moduli have "
        "3/2 of it. From a chain with all pairs the rod differs by its reach above all."
    )
    recorder.text(
        "**Speed.** The rod takes as many steps as the chain, because both resolve the same stiff "
        "stretch and shear. Its steps cost a quarter or less of those of 200 spheres, not a "
        "twentieth: a point of a rod couples to all points of its element, a sphere to two on "
        "either side, and both run in the same machine code."
    )


def compare(
    recorder: Recorder, name: str, case: Case, spheres: tuple[int, int]
) -> tuple[str, float, float, float]:
    """Record the order of the distance in d/L."""
    far, near = (distance(case, n) for n in spheres)
    order = math.log(far / near) / math.log((spheres[1] - 1) / (spheres[0] - 1))
    recorder.bound(
        f"{case.title}: order in d/L of the distance of chain and rod",
        order,
        least=1.65 if recorder.quick else 1.8,
        most=2.6,
        source="links: midpoint rule; 2s gains from d/L of the stretch, which falls with it",
    )
    return name, far, near, order
