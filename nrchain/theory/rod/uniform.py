"""(F, M) and (f⋆, m⋆) of a chain in uniform strain of any size, from the simulated wrenches.

The spheres sit on a helix at s = i d: each feels the same wrench in its frame. With W_ij the wrench
of sphere j on sphere i, about one common point, a pair exerts

    A = (W_ij − W_ji)/2     across every cut between i and j, and
    S = (W_ij + W_ji)/2     on each of the two.

A is carried to the cut at r(s), and summed over the pairs that cross it. Its mean over a spacing is
the stress (F, M). S per length are the sources; they vanish if the interaction is reciprocal.

Forces can be assigned to a cut in other ways. This one has the power of the chain at any strain:
−(F·ε̇ + M·τ̇) per length and the power of S. The passive chain has F = ∂𝓔/∂ε and M = ∂𝓔/∂τ. The
balance of a uniform state, (f, m) = wrench per length − (Π × F, Π × M + h × F), holds identically.

Linear response assigns forces otherwise (:mod:`nrchain.theory.rod.coarse_graining`): F and M then
include how sources change with the gradient of the strain.

With ``slip.neighbours = "all"``, pairs up to N − 1 places apart act, as in the chain of the scene:
an endless bent chain would run into itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.notebook import record_html
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.rod.constants import Constants
from nrchain.theory.rod.uniform_chain import WEIGHTS, UniformChain
from nrchain.wording import brief

STEP = 0.005
"""Step of the differences: in strain, and in the angle between the spheres farthest apart that act
on each other."""


@dataclass(frozen=True, eq=False)
class Response:
    """Stress and sources in uniform states of strain, in the moving frame, per length at rest.

    Attributes
    ----------
    strains
        (ε, τ) (..., 6).
    active, elastic
        (F, M) (..., 6) of slip and of the elasticity; :attr:`stress` is their sum.
    source
        (f⋆, m⋆) (..., 6).
    error, source_error
        Bounds of the absolute errors of the stress and of the sources, which are those of rounding.
    """

    strains: np.ndarray
    active: np.ndarray
    elastic: np.ndarray
    source: np.ndarray
    error: np.ndarray
    source_error: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def stress(self) -> np.ndarray:
        """(F, M) (..., 6)."""
        return self.active + self.elastic


def uniform_response(scene: Scene, strains: ArrayLike) -> Response:
    """Stress and sources of the chain of a scene in uniform states of strain (ε, τ) (..., 6).

    Raises :class:`~nrchain.errors.SceneError` for a scene without uniform states, for friction
    between spheres, and for strains that bring spheres into contact.

    >>> import nrchain
    >>> from nrchain import rod
    >>> scene = nrchain.load_scene("buckling")
    >>> bent = rod.uniform_response(scene, [0, 0, 0, 0, 0, 0.01])  # τ₃ = 0.01
    >>> bent.stress.shape
    (6,)
    """
    chain = UniformChain(require_scene(scene))
    states = finite_array("strains", strains)
    if states.shape[-1:] != (6,):
        raise SceneError("strains", states.shape, "the shape must be (..., 6): ε and τ")
    found = [(*chain.respond(s), *chain.rounding(s)) for s in states.reshape(-1, 6)]
    parts = np.array(found).reshape(-1, 5, 6).swapaxes(0, 1).reshape(5, *states.shape)
    return Response(states, *parts)


def cut_constants(scene: Scene) -> tuple[Constants, Constants, Constants]:
    """Active and elastic constants of uniform states at zero strain, and bounds of their errors.

    Derivatives are differences of eighth order. Their error is estimated by those of half the step.
    """
    chain, d = UniformChain(require_scene(scene)), scene.chain.spacing
    steps = STEP * np.repeat([1.0, 1.0 / (d * max(chain.reach, 1))], 3)
    rest = chain.respond(np.zeros(6))
    slopes, finer = chain.slopes(steps), chain.slopes(0.5 * steps)
    lost, lost_source = chain.rounding(np.zeros(6))
    active, elastic, source = slopes
    apart = np.abs(slopes - finer)
    none, zero = np.zeros(6), np.zeros((6, 6))
    weight = 2.0 * float(np.abs(WEIGHTS).sum())
    error, source_error = (weight * part[:, None] / steps for part in (lost, lost_source))
    return (
        Constants(active, source, rest[0], rest[2]),
        Constants(elastic, zero, rest[1], none),
        Constants(apart[0] + apart[1] + error, apart[2] + source_error, lost, lost_source),
    )
