"""How a scene sums over all pairs, and the error of its sums, measured against direct sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.effects.flow import Flow
from nrchain.effects.registry import acting
from nrchain.effects.shared.slip_flow import active_modes, make_flow
from nrchain.effects.strain import DisturbanceEffect, Strain
from nrchain.hydrodynamics.tree.accuracy import break_even
from nrchain.motion.model import Model
from nrchain.planning.plan_line import Line
from nrchain.scene.scene import Scene

SAMPLE = 64
"""Spheres at which sums are compared with direct sums."""


@dataclass(frozen=True)
class PairSumError:
    """The error of one sum over all pairs by a tree, relative to its largest value.

    Attributes
    ----------
    name
        ``"slip"``, ``"friction"`` or the effect of a background flow.
    velocity, spin
        Largest error of v over the largest |v|, and of ω over the largest |ω|, in components.
    allowed
        The accuracy that the scene asks for.
    spheres
        Number of spheres at which the sums were compared.
    """

    name: str
    velocity: float
    spin: float
    allowed: float
    spheres: int

    def line(self) -> Line:
        """The error as a line of a plan."""
        return Line(
            f"sum of {self.name}",
            f"error = {max(self.velocity, self.spin):.1e}",
            f"of the largest value, by a tree: against direct sums at {self.spheres} spheres of the"
            f" start; {self.allowed:g} is allowed",
        )


def sum_over_pairs(scene: Scene) -> str:
    """How all pairs are summed, in words; empty if nrchain sums over no pairs but near ones."""
    friction, slip = scene.friction, scene.slip
    parts = (bool(active_modes(scene)), slip), (friction.kind == "pairwise", friction)
    reaches = [p.neighbours for acts, p in parts if acts and p.backend == "native"]
    if Strain.acts(scene):
        reaches.append(Flow.section(scene).neighbours)
    if "all" not in reaches:
        return ""
    if scene.chain.ends == "periodic" or scene.chain.particles < break_even(scene.pair_accuracy):
        return "direct"
    return f"by a tree, relative error {scene.pair_accuracy:g}"


def unused_accuracy(scene: Scene) -> str:
    """Why ``slip.accuracy`` changes nothing; empty if it does."""
    way = sum_over_pairs(scene)
    if not way:
        return "nrchain sums neither slip nor friction nor a disturbance over all pairs"
    if scene.chain.ends == "periodic":
        return "the images of a periodic chain are summed directly"
    if way == "direct" and scene.pair_accuracy > 0.0:
        fewest = break_even(scene.pair_accuracy)
        return f"at this accuracy, chains of fewer than {fewest:g} spheres are summed directly"
    return ""


def pair_sum_errors(
    scene: Scene, positions: np.ndarray, frames: np.ndarray, sample: int = SAMPLE
) -> list[PairSumError]:
    """The errors of the sums that a scene leaves to a tree, at positions (N, 3) and frames.

    The friction is that of the wrenches of the scene at these poses.
    """
    count, accuracy = scene.chain.particles, scene.pair_accuracy
    spheres = np.unique(np.linspace(0, count - 1, min(sample, count)).astype(int))
    found, slip = [], make_flow(scene)
    if slip and slip.tree:
        twists = np.zeros((count, 6))
        slip.add_twists(positions, frames, twists)
        found.append(_error("slip", twists, slip.direct_twists(spheres), spheres, accuracy))
    model = Model(scene)
    if model.friction and model.friction.tree:
        twists, wrenches = np.zeros((count, 6)), model.wrenches(positions, frames)
        model.friction.apply(positions, wrenches, twists)
        exact = model.friction.direct_twists(spheres)
        found.append(_error("friction", twists, exact, spheres, accuracy))
    for effect in acting(scene):
        if issubclass(effect, DisturbanceEffect) and (flow := effect(scene).disturbance).tree:
            twists = np.zeros((count, 6))
            flow.add_twists(positions, twists)
            exact = flow.direct_twists(positions, spheres)
            found.append(_error(effect.name, twists, exact, spheres, accuracy))
    return found


def _error(
    name: str, twists: np.ndarray, exact: np.ndarray, spheres: np.ndarray, accuracy: float
) -> PairSumError:
    errors, largest = np.abs(twists[spheres] - exact), np.abs(twists)
    velocity, spin = (
        float(errors[:, part].max() / largest[:, part].max()) if largest[:, part].any() else 0.0
        for part in (slice(3), slice(3, 6))
    )
    return PairSumError(name, velocity, spin, accuracy, len(spheres))
