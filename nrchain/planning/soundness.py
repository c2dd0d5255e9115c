"""Does the chain of a scene hold? Its bonds, links and spheres, from its straight state.

A chain is judged by its own straight state and by how it leaves it:

- the loads of the links (:mod:`nrchain.theory.line_loads`) against the moduli that hold them;
- whether the straight chain comes to rest, or its spheres touch or its links turn over first
  (:mod:`nrchain.theory.straight_state`);
- what grows about that state (:mod:`nrchain.theory.straight_growth`): bonds that stretch or shear
  unstably, or bends. The links of a bend then carry loads that straight links do not.

A bend relieves held ends: between clamps and on a ring its links carry up to what they would carry
with free ends. Under a thrust T a bend turns each link by √(T d/μ⊥): an elastica has the curvature
√(T/B) with B = μ⊥ d, times d (Landau and Lifshitz, Theory of Elasticity, sec. 19).

The rules are in :mod:`nrchain.planning.weaknesses`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.notebook import record_html
from nrchain.planning.weaknesses import (
    FOLDS,
    Weakness,
    bend_weaknesses,
    bond_weaknesses,
    growth_weaknesses,
    straight_weaknesses,
)
from nrchain.scene.loading import load_scene, require_scene
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene
from nrchain.theory.line_loads import LineLoads, line_loads
from nrchain.theory.straight_growth import StraightGrowth, straight_growth
from nrchain.theory.straight_state import StraightState, straight_state
from nrchain.wording import brief

LARGE = 0.1
"""Slopes to which a bend must grow before the loads of its links are judged."""


@dataclass(frozen=True)
class Judgement:
    """Loads, straight state, growth and weaknesses of the chain of a scene.

    ``loads`` are those of the straight chain, ``carried`` the largest that bends may cause. The two
    differ for clamped and periodic chains whose bends become large within the run (``bends``).
    ``growth`` is None if the chain stops to be straight before the run is over.
    """

    loads: LineLoads
    carried: LineLoads
    state: StraightState
    growth: StraightGrowth | None
    bends: bool
    weaknesses: tuple[Weakness, ...]

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def sound(self) -> bool:
        """Whether no weakness was found."""
        return not self.weaknesses


def judge(scene: Scene) -> Judgement:
    """The loads, straight state, growth and weaknesses of the chain of a scene.

    Raises :class:`~nrchain.errors.SceneError` for a chain that does not stay straight, see
    :func:`~nrchain.theory.line_loads.line_loads`, and FloatingPointError beyond the range of
    floats.

    >>> from nrchain import load_scene
    >>> judge(load_scene("buckling")).sound
    True
    >>> long = load_scene("buckling", **{"chain.particles": 64, "chain.ends": "free"})
    >>> {weakness.kind.value for weakness in judge(long).weaknesses} >= {"stretch"}
    True
    """
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        state = straight_state(require_scene(scene))
        loads = line_loads(scene)
        growth = None if state.stopped else straight_growth(scene, state)
        bends = growth is not None and _becomes_large(scene, growth)
        carried = loads
        if bends and scene.chain.ends != "free":
            carried = line_loads(load_scene(scene, **{"chain.ends": "free"}))
    found = [*straight_weaknesses(scene, state), *bond_weaknesses(scene, loads, carried)]
    if growth is not None:
        found += growth_weaknesses(scene, growth, bends)
    if bends:
        found += bend_weaknesses(scene, carried)
    return Judgement(loads, carried, state, growth, bends, tuple(found))


def _becomes_large(scene: Scene, growth: StraightGrowth) -> bool:
    """Whether bends grow e-fold or more, and from the slopes of the start to :data:`LARGE`."""
    folds = growth.across.rate * scene.run.end
    positions, frames = initial_poses(scene)
    offsets = np.linalg.norm(positions[:, 1:] - positions[:, 1:].mean(axis=0), axis=1)
    tilts = np.linalg.norm(frames[:, 0, 1:], axis=1)
    slope = max(float(offsets.max()) / scene.chain.spacing, float(tilts.max()))
    return folds >= FOLDS and slope > 0.0 and math.log(slope) + folds >= math.log(LARGE)
