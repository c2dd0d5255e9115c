"""(F, M, f, m) = s₀ + A x + x·Q·x: the law of the rod that a chain of neighbours becomes.

Between two spheres that interact lies a link. The wrenches of the pair do the virtual work

    −Σ(Ξ)·δΞ d + σ(Ξ)·δη d,

with Ξ its strain, from the relative pose exp(d Ξ), δη the mean virtual displacement, Σ half the
difference and σ the mean of the wrenches of both. Summed over links, this is the weak form of a rod
with the stress and the sources of uniform strain (``stress="cut"``), up to relative order d². It
holds up to the ends of the chain, of nearest neighbours. Spheres have their drag, fields and half a
spacing at each end to themselves.

The strain of a link is not quite that of the rod at its middle: Ξ = (ε − (d²/12) τ′ × e₁, τ) + ….
Where ε itself is small, as in a rod that hardly shears, the term in τ′ is as large. A source with a
modulus H_ε therefore has a part G·τ′ with

    G = (d²/12) H_ε (e₁ ×).

For 3a it is a third of the force C^{Fτ}·τ of uniform strain, and the bending law is then that of
the chain, −(13/18) (qd)³. It is written as a stress G·τ with the sources −τ × (G·τ) and, for its
force, −r′ × F. They differ from G·τ′ at free ends alone, where τ vanishes to the order kept.

Strains enter to second order: products of τ in the sources of 3a are as large as G·τ′.
"""

from __future__ import annotations

import numpy as np

from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.rod.constants import TURN, Constants, cross
from nrchain.theory.rod.material import Material
from nrchain.theory.rod.uniform import STEP, cut_constants
from nrchain.theory.rod.uniform_chain import WEIGHTS, UniformChain

CURVED = 0.02
"""Step of a second difference, in ε and in τ d."""


def chain_law(scene: Scene) -> tuple[Material, np.ndarray]:
    """The linear material and Q (12, 6, 6) of the chain of a scene.

    Raises :class:`~nrchain.errors.SceneError` as :func:`~nrchain.theory.rod.uniform_response`.
    """
    active, elastic, error = cut_constants(require_scene(scene))
    chain, total = UniformChain(scene), active + elastic
    gradient = gradient_source(scene, chain)
    C, H = total.C.copy(), total.H.copy()
    presource = total.presource.copy()
    C[:, 3:] += gradient
    H[3:, 3:] -= TURN @ gradient[:3]
    quadratic = second_order(scene, chain)
    for a in range(3):
        # −τ × (G·τ) and −ε × (G·τ), as coefficients of products of strains
        turn = cross(np.eye(3)[a])
        quadratic[6:9, 3 + a, 3:] -= turn @ gradient[:3]
        quadratic[9:, 3 + a, 3:] -= turn @ gradient[3:]
        quadratic[9:, a, 3:] -= turn @ gradient[:3]
    drag = np.diag(np.repeat(scene.drag, 3)) / scene.chain.spacing
    return Material(Constants(C, H, total.prestress, presource), drag, error), quadratic


def gradient_source(scene: Scene, chain: UniformChain) -> np.ndarray:
    """G (6, 3): (f, m) per τ′ of the strain of links."""
    slopes = np.zeros((6, 3))
    if chain.reach:
        for axis in range(3):
            state = np.zeros(6)
            for n, weight in enumerate(WEIGHTS, start=1):
                state[axis] = n * STEP
                change = chain.second_moment(state) - chain.second_moment(-state)
                slopes[:, axis] += weight / STEP * change
    return slopes @ TURN / 12.0


def second_order(scene: Scene, chain: UniformChain) -> np.ndarray:
    """Q (12, 6, 6), symmetric: half the second derivatives of stress and sources at rest.

    Differences of fourth order, by polarisation: x·Q·x along single strains and along sums of two.
    """
    units = CURVED * np.repeat([1.0, 1.0 / (scene.chain.spacing * max(chain.reach, 1))], 3)

    def along(state: np.ndarray) -> np.ndarray:
        """x·Q·x (12,) of a state x."""
        rest, near, far = (
            sum(_total(chain, sign * n * state) for sign in (1.0, -1.0)) for n in (0.0, 1.0, 2.0)
        )
        return np.asarray((16.0 * near - far - 15.0 * rest) / 24.0)

    single = [along(unit * row) for unit, row in zip(units, np.eye(6), strict=True)]
    found = np.zeros((12, 6, 6))
    for a in range(6):
        found[:, a, a] = single[a] / units[a] ** 2
        for b in range(a):
            both = np.zeros(6)
            both[a], both[b] = units[a], units[b]
            mixed = 0.5 * (along(both) - single[a] - single[b])
            found[:, a, b] = found[:, b, a] = mixed / (units[a] * units[b])
    return found


def _total(chain: UniformChain, strain: np.ndarray) -> np.ndarray:
    """(F, M, f, m) (12,) in one state."""
    active, elastic, source = chain.respond(strain)
    return np.concatenate([active + elastic, source])
