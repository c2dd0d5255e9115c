"""What each effect of a scene contributes to its run and costs of its time, as a table.

:mod:`nrchain.estimate` finds the contributions; they depend on no clock. The cost of an effect is
measured: the time of a right-hand side with and without it, including its products and solves,
after compilation. :mod:`nrchain.work` defines the cost of the run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from nrchain.accuracy.effect_cells import COLUMNS, explain_marks, is_known, name, row
from nrchain.accuracy.timing import PILOT, predict_cost
from nrchain.errors import SceneError
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.counted_work import evaluation_work, interpreted_work
from nrchain.planning.effect_changes import Refused, refused_changes
from nrchain.planning.estimate import (
    PROBE_TOLERANCE,
    Estimates,
    estimate_effects,
)
from nrchain.run.work import DEFINITION, FEWEST_STEPS, RunCost, medians
from nrchain.scene.scene import Scene

REPEATS, BATCH = 15, 3e-4
"""Batches of calls by which a right-hand side is timed, and the nominal seconds of a batch."""


@dataclass(frozen=True)
class EffectPlan:
    """The contribution of each effect of a scene, and its measured cost.

    Attributes
    ----------
    estimates
        The contributions, and the probe that gave them.
    own, others
        Measured seconds of one right-hand side with its products and solves: of the scene, and of
        every changed scene in the order of the estimates.
    cost
        The predicted cost of the run, or in words why it is not known.
    probe
        The counted work of the probe over that of the run; None if not known.
    refused
        The changes that the scene does not allow.
    """

    estimates: Estimates
    own: float
    others: list[float]
    cost: RunCost | str
    probe: float | None
    refused: list[Refused]

    def rows(self) -> list[tuple[str, ...]]:
        """One row an effect, with the cells of :data:`COLUMNS`; + marks effects left out."""
        return [
            row(one, self.own, other)
            for one, other in zip(self.estimates.estimates, self.others, strict=True)
        ] + [(name(one), "not possible", *[""] * (len(COLUMNS) - 2)) for one in self.refused]

    def remarks(self) -> list[str]:
        """What the marks * and ? mean, and why a row has no numbers: one line a row."""
        return [
            f"{name(one.change)}: {one.stops or explain_marks(one)}"
            for one in self.estimates.estimates
            if one.stops or not one.ends or not is_known(one, one.displacement + one.turn)
        ] + [f"{name(one)}: {one.reason}" for one in self.refused]

    def notes(self) -> list[str]:
        """What the columns mean, what the run costs, and how the probe was made."""
        wave = self.estimates.wave
        growth = (
            "growth: not defined, as the chain has no plane waves"
            if wave is None
            else f"growth: contribution to the growth rate of bending at wave number q = {wave:.3g}"
        )
        left_out = [one for one in self.estimates.estimates if one.change.kind == "add"]
        added = "+ marks effects that the scene leaves out; their rows show what they would add"
        return [
            *([added] if left_out or any(one.kind == "add" for one in self.refused) else []),
            "velocity: largest contribution to |v|/a or |ω| of any sphere, per unit time; a range "
            "goes from its value at the start to its maximum over the probe",
            growth,
            "displaced, rotated: largest change of a position, in radii, and of a frame, in "
            "radians, at the end of the run, or where the first of the two runs stops",
            "cost: share of the time of a right-hand side that the effect takes, or would add",
            f"the run: {self.cost if isinstance(self.cost, str) else self.cost.words()}",
            DEFINITION,
            self._probe_note(),
        ]

    def _probe_note(self) -> str:
        """The tolerance, the end and the work of the probe."""
        if self.estimates.probed == 0.0:
            return "the budget allows no probe"
        work = f"{self.estimates.work:.3g} right-hand sides"
        if self.probe is not None:
            work = f"{self.probe:.2g} times the work of the run"
        reached = f"t = {self.estimates.probed:.4g}"
        return f"the probe reached {reached} with tolerance {PROBE_TOLERANCE:g}; it took {work}"


def plan_effects(scene: Scene, estimates: Estimates | None = None) -> EffectPlan:
    """Estimate what every effect of a scene contributes, and measure what it costs.

    Errors as for :func:`nrchain.estimate.estimate_effects`.
    """
    found = estimates or estimate_effects(scene)
    own, *others = evaluation_times([scene, *(one.change.scene for one in found.estimates)])
    cost = _cost(scene)
    probe = None
    if isinstance(cost, RunCost) and cost.factors and cost.work.evaluations:
        probe = found.work / (cost.work.evaluations * sum(cost.factors) / 2.0)
    return EffectPlan(found, own, others, cost, probe, refused_changes(scene))


def _cost(scene: Scene) -> RunCost | str:
    """The predicted cost of the run of a scene, or why it is not known."""
    if FEWEST_STEPS * evaluation_work(scene) > PILOT:
        return f"not known: {FEWEST_STEPS} steps take more work than a plan may spend"
    try:
        return predict_cost(scene).cost
    except SceneError as error:
        return f"not known: the run is refused: {error}"


def evaluation_times(scenes: Sequence[Scene]) -> list[float]:
    """Processor seconds of a right-hand side of each scene at its start, with products and solves.

    The scenes take turns, so that other programs on the machine affect all of them alike.
    """
    batches = [max(int(BATCH / interpreted_work(scene)), 1) for scene in scenes]
    return medians([_evaluation(scene) for scene in scenes], REPEATS, batches)


def _evaluation(scene: Scene) -> Callable[[], None]:
    """One right-hand side with two products and two solves, already compiled."""
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, *starting_poses(scene))
    still, out = np.zeros(chain.dimension), np.empty(chain.dimension)
    vector = np.cos(np.arange(float(chain.dimension)))

    def once() -> None:
        chain.rates(0.0, still, out)
        for _ in range(2):
            chain.product(vector, out)
            chain.solve(vector, out)

    if chain.dimension == 0:
        return lambda: None
    chain.linearise(0.0, still)
    try:
        chain.factorise(1e-6)
    except FloatingPointError:  # not finite: there is nothing to time
        return lambda: None
    once()
    return once
