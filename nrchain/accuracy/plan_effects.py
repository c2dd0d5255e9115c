"""What each effect of a scene does to its run and what it takes of its time, as a table.

Contributions are those of :mod:`nrchain.estimate`, and no clock has a part in them. Costs are
measured: the right-hand side of the scene, with and without the effect, with the products and
solves that come with it, compiled beforehand. What the run will cost is told as for a run that is
done: see :mod:`nrchain.work`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from nrchain.accuracy.timing import PILOT, foretell
from nrchain.errors import SceneError
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.planning.estimate import (
    PROBE_TOLERANCE,
    RESOLUTION,
    Estimate,
    Estimates,
    estimate_effects,
)
from nrchain.planning.nominal_cost import evaluation_cost
from nrchain.planning.scene_changes import Change, Refused, refused_changes
from nrchain.planning.start import starting_poses
from nrchain.run.work import DEFINITION, FEWEST_STEPS, RunCost, medians
from nrchain.scene.scene import Scene
from nrchain.wording import span

REPEATS, BATCH = 15, 3e-4
"""Each right-hand side is timed in so many batches, of so many nominal seconds or one call."""

COLUMNS = ("effect", "velocity", "growth", "end", "turned", "time")
"""What :meth:`EffectPlan.rows` has in its columns."""


@dataclass(frozen=True)
class EffectPlan:
    """The estimates of a scene and the measured costs that go with them.

    Attributes
    ----------
    estimates
        Contributions, and the probe they come from.
    own, others
        Measured seconds of one right-hand side, with what comes with it: of the scene, and of every
        changed scene in the order of the estimates.
    cost
        What the run of the scene will take, or in words why that is not known.
    probe
        The work of the probe over that of the run, by count; None where that is not known.
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
        """One row an effect, in the columns of :data:`COLUMNS`; those with + are left out."""
        return [
            _row(one, self.own, other)
            for one, other in zip(self.estimates.estimates, self.others, strict=True)
        ] + [(_name(one), "not possible", *[""] * (len(COLUMNS) - 2)) for one in self.refused]

    def remarks(self) -> list[str]:
        """Of which time the differences are that are not those of the end of the run.

        Each explains the mark that its row shows.
        """
        return [
            f"{_name(one.change)}: {one.stops or _unknown(one)}"
            for one in self.estimates.estimates
            if one.stops or not one.ends or not _is_known(one, one.displacement + one.turn)
        ] + [f"{_name(one)}: {one.reason}" for one in self.refused]

    def notes(self) -> list[str]:
        """What the columns mean, and what the numbers rest on."""
        wave = self.estimates.wave
        growth = (
            "growth: no plane waves to tell it by"
            if wave is None
            else f"growth: part of the rate at which bending of q = {wave:.3g} grows"
        )
        left_out = [one for one in self.estimates.estimates if one.change.kind == "add"]
        added = "+ marks effects that the scene leaves out, and what they would bring"
        return [
            *([added] if left_out or any(one.kind == "add" for one in self.refused) else []),
            "velocity: largest change of a velocity or spin, in radii or radians per unit time, at "
            "the start and at most on the way",
            growth,
            "end: how far a sphere ends, in radii, from where it would with the change; "
            "turned: its frame, in radians; where a run stops, at that time",
            "time: part of a right-hand side that the effect takes, or would add",
            f"the run: {self.cost if isinstance(self.cost, str) else self.cost.words()}",
            DEFINITION,
            self._probe_note(),
        ]

    def _probe_note(self) -> str:
        """How far the probe went, and what it took."""
        if self.estimates.probed == 0.0:
            return "the budget allows no probe"
        work = f"{self.estimates.work:.3g} right-hand sides"
        if self.probe is not None:
            work = f"{self.probe:.2g} times the work of the run"
        reached = f"to t = {self.estimates.probed:.4g}"
        return f"the probe, at tolerance {PROBE_TOLERANCE:g} {reached}, is {work}"


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
    """What the run of a scene will cost, or why that is not known."""
    if FEWEST_STEPS * evaluation_cost(scene) > PILOT:
        return f"not known: {FEWEST_STEPS} steps of it are more work than a plan may take"
    try:
        return foretell(scene).cost
    except SceneError as error:
        return f"not known: it is refused: {error}"


def evaluation_times(scenes: Sequence[Scene]) -> list[float]:
    """Seconds of a right-hand side of each scene at its start, with its products and solves.

    They take turns, and the time of this thread counts: not what else the machine does.
    """
    batches = [max(int(BATCH / evaluation_cost(scene)), 1) for scene in scenes]
    return medians([_evaluation(scene) for scene in scenes], REPEATS, batches)


def _evaluation(scene: Scene) -> Callable[[], None]:
    """One right-hand side with two products and two solves, called once so that it is compiled."""
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
    except FloatingPointError:  # numbers beyond any run: there is nothing to time
        return lambda: None
    once()
    return once


def _row(one: Estimate, own: float, other: float) -> tuple[str, ...]:
    drop = one.change.kind == "drop"
    growth = "" if one.growth is None else _signed(one.growth)
    share = (own - other) / own if drop and own else (other - own) / own if own else 0.0
    return (
        _name(one.change),
        span(_size(one.velocity), _size(one.velocity_along), sign="–"),
        growth,
        *(_end(one, value) for value in (one.displacement, one.turn)),
        f"{100.0 * share:+.0f} %",
    )


def _end(one: Estimate, value: float) -> str:
    """A difference at the end: marked if it is of another time, ? where there is none."""
    if not _is_known(one, value):
        return "?"
    size = _size(value) if value == 0.0 or value >= RESOLUTION else f"<{_size(RESOLUTION)}"
    return size + ("" if one.ends else "*")


def _is_known(one: Estimate, value: float) -> bool:
    return one.until > 0.0 and math.isfinite(value)


def _unknown(one: Estimate) -> str:
    """What the marks of a row mean that is not of the end of the run."""
    if any(_is_known(one, value) for value in (one.displacement, one.turn)):
        return f"* is at t = {one.until:.4g}, where the probe ended; the end is not known"
    if one.until == 0.0:
        return "? stands for what the budget of the probes allowed no step to find"
    return f"? stands for what is not finite at t = {one.until:.4g}, where the probe ended"


def _signed(value: float) -> str:
    return ("+" if value > 0.0 else "") + _size(value)


def _size(value: float) -> str:
    """Two digits, and an exponent without its zeros where that is shorter."""
    if not math.isfinite(value):
        return "?"
    digits, exponent = f"{value:.1e}".split("e")
    return min(f"{value:.2g}", f"{digits.removesuffix('.0')}e{int(exponent)}", key=len)


def _name(change: Change | Refused) -> str:
    return change.effect if change.kind == "drop" else f"+ {change.effect}"
