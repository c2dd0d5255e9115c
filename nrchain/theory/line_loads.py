"""T_i = Σ_{j≤i} f_j: the tension and moment of every link of the straight chain, with V and Ω.

On the straight chain slip, fields and flows give sphere j the velocity u_j along it. Links that do
not stretch force all spheres to move with one velocity V. The link forces f_j on the spheres follow
from the friction μ of the scene:

    Σ_k μ_jk f_k + u_j = V,      Σ_j f_j = 0      (free and periodic ends)
    Σ_k μ_jk f_k + u_j = 0                        (clamped ends, f with that of the supports).

With one-body friction f_j = γ_T (V − u_j): the tension T_i of the link from i to i + 1, positive
if it pulls, is the drag on the spheres 0 … i minus the other forces on them. Clamped and periodic
ends leave one constant free; it follows from the extensions of the links, which sum to zero.
Torques about the chain give its spin Ω and the moment of each link in the same way.

The law is exact for strengths that differ between spheres. Spheres are at their rest distance d:
the extension of links is of the next order in T/λ∥d (:mod:`nrchain.theory.straight_state`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.effects.base import Effect
from nrchain.effects.registry import acting
from nrchain.effects.shared.elasticity import elasticity_of
from nrchain.errors import SceneError
from nrchain.hydrodynamics.friction import PairFriction
from nrchain.motion.model import Model
from nrchain.notebook import record_html
from nrchain.potential.chain import REACH, terms_of
from nrchain.scene.loading import load_scene, require_scene
from nrchain.scene.scene import Scene
from nrchain.wording import brief

ACROSS = 1e-10
"""Velocities across the chain below this fraction of the largest contribution are rounding."""

ACCURACY = 1e-12
"""Relative residual of the link forces with friction between spheres."""

ROUNDING = 1e-12
"""Relative differences of velocities below this are rounding."""

Extension = Callable[[np.ndarray], float]

_ALONG = (0, 3)
"""The components of a twist or wrench that a straight chain has: along x and about x."""


@dataclass(frozen=True)
class LineLoads:
    """T_i and m_i of the links of a straight chain at its rest length, with V and Ω.

    Attributes
    ----------
    tension, moment
        (L,) of each link: the force that pulls its spheres together, and the torque about x with
        which the sphere ahead acts on that behind. N − 1 links, or N on a periodic chain.
    velocity, spin
        V (3,) and the rate Ω about x of the whole chain; zero with clamped ends.
    """

    tension: np.ndarray
    moment: np.ndarray
    velocity: np.ndarray
    spin: float

    __repr__ = brief
    _repr_html_ = record_html


def line_loads(scene: Scene) -> LineLoads:
    """T_i = Σ_{j≤i} f_j and m_i = Σ_{j≤i} τ_j, with V and Ω, of the straight chain of a scene.

    Raises :class:`~nrchain.errors.SceneError` if the chain does not stay straight: spheres rotate
    about an axis across it, or move apart across it.

    >>> from nrchain import load_scene
    >>> halves = {"slip.3t": [500.0] * 8 + [-500.0] * 8, "slip.2s": None, "run.end": 1.0}
    >>> round(line_loads(load_scene("wave", **{"chain.particles": 16, **halves})).tension[7], 1)
    -49.7
    """
    loose = without_links(require_scene(scene))
    poses = straight_poses(scene)
    twists = Model(loose).twists(*poses)
    refuse_bending(loose, poses, twists)
    clamped = scene.chain.ends == "clamped"
    mobility = _mobility(scene, poses[0])
    found = []
    for component, compliance in zip(_ALONG, _compliances(scene), strict=True):
        held = _constraint(mobility, component, twists[:, component], not clamped)
        through = np.cumsum(held)[: len(held) - (scene.chain.ends != "periodic")]
        if scene.chain.ends != "free":
            through = through - held[0] * clamped
            through = through - compliance(through) / compliance(np.ones_like(through))
        wrench = np.zeros((len(held), 6))
        wrench[:, component] = held
        moved = twists + mobility(wrench)
        found.append((through, 0.0 if clamped else float(moved[:, component].mean())))
    (tension, speed), (moment, spin) = found
    across = np.zeros(2) if clamped else twists[:, 1:3].mean(axis=0)
    return LineLoads(tension, moment, np.array([speed, *across]), spin)


def without_links(scene: Scene) -> Scene:
    """The scene of the same spheres without links and clamps."""
    slack = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
    ends = "free" if scene.chain.ends == "clamped" else scene.chain.ends
    return load_scene(scene, **{"elasticity.ratio": None, **slack, "chain.ends": ends})


def straight_poses(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 3), i d along x, and frames (N, 3, 3) along the lab."""
    count = scene.chain.particles
    positions = np.zeros((count, 3))
    positions[:, 0] = scene.chain.spacing * np.arange(count)
    return positions, np.broadcast_to(np.eye(3), (count, 3, 3)).copy()


def refuse_bending(scene: Scene, poses: tuple[np.ndarray, np.ndarray], twists: np.ndarray) -> None:
    """Raise SceneError if twists (N, 6) rotate or separate the spheres across a straight chain.

    Spheres may all drift alike, unless the ends are clamped.
    """
    if not _bends(scene, twists):
        return
    model = Model(scene)
    causes = [cls for cls in acting(scene) if _bends(scene, _twists_of(cls, scene, model, poses))]
    allowed = (
        "turns or moves the spheres of the straight chain across it, so that it does not stay"
        f" straight: at up to {np.abs(_across(scene, twists)).max():.3g}"
    )
    cause = causes[0] if causes else None
    if cause is None or cause.key.startswith("slip"):
        axes = {label: slip.axis for label, slip in scene.slip.modes.items()}
        raise SceneError("slip", axes, f"with these axes it {allowed}")
    raise SceneError(cause.key, cause.value(scene), allowed)


def _across(scene: Scene, twists: np.ndarray) -> np.ndarray:
    """(N, 4): the velocities across the chain that are not shared, and a ω across it."""
    velocities = twists[:, 1:3]
    if scene.chain.ends != "clamped":
        velocities = velocities - velocities.mean(axis=0)
    return np.hstack([velocities, scene.chain.radius * twists[:, 4:]])


def _bends(scene: Scene, twists: np.ndarray) -> bool:
    scale = np.abs(twists * np.repeat([1.0, scene.chain.radius], 3)).max(initial=0.0)
    return bool(np.abs(_across(scene, twists)).max(initial=0.0) > ACROSS * scale)


def _twists_of(
    cls: type[Effect], scene: Scene, model: Model, poses: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """(v, ω) (N, 6) of one effect by itself; zero for effects that the model sums together."""
    out = np.zeros((model.count, 6))
    if cls.fused or cls.gives == "mobility":
        return out
    if cls.gives == "twist":
        cls(scene).add_twists(*poses, out)
        return out
    cls(scene).add_wrenches(*poses, out)
    return model.mobile_twists(poses[0], out)


def _compliances(scene: Scene) -> tuple[Extension, Extension]:
    """The total extension, and the total twist, due to loads (L,) of the links."""
    if scene.chain.ends == "clamped":
        return _extension_between_clamps(scene), np.sum
    return np.sum, np.sum


def _extension_between_clamps(scene: Scene) -> Extension:
    """Loads (L,) ↦ λ∥ Σ extensions: links over four spheres and over two differ in stiffness."""
    # the kernel of the chain, if it has the term
    terms = terms_of(scene.moduli)
    own = terms if "stretch" in terms else ("stretch",)
    unit = elasticity_of(scene, (1.0, 0.0, 0.0, 0.0), own)
    blocks = np.zeros((scene.chain.particles, 2 * REACH + 1, 6, 6))
    unit.add_jacobian(*straight_poses(scene), blocks)
    # with the first sphere held, the shift of the last is the sum of all extensions
    stiffness = from_blocks(-blocks[:, :, :1, :1], periodic=False)[1:, 1:]
    factors = sparse_factors(stiffness)

    def extension(loads: np.ndarray) -> float:
        pulled = np.append(loads[:-1] - loads[1:], loads[-1])
        return float(factors.solve(pulled)[-1])

    return extension


def sparse_factors(matrix: Any) -> Any:
    """The factors of a sparse matrix; FloatingPointError for one that is singular to rounding."""
    from scipy.sparse.linalg import splu

    try:
        return splu(matrix.tocsc())
    except RuntimeError as error:
        raise FloatingPointError(f"the matrix of the straight chain is singular: {error}") from None


def from_blocks(blocks: np.ndarray, *, periodic: bool) -> Any:
    """The sparse matrix (kN, kN) of blocks (N, 2w + 1, k, k), of sphere i with sphere i + m − w."""
    from scipy.sparse import coo_array

    count, width, size = blocks.shape[:3]
    i, m, p, q = np.indices(blocks.shape)
    j = i + m - width // 2
    inside = np.ones_like(j, bool) if periodic else (j >= 0) & (j < count)
    places = ((size * i + p)[inside], (size * (j % count) + q)[inside])
    return coo_array((blocks[inside], places), shape=(size * count, size * count)).tocsc()


def _mobility(scene: Scene, positions: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """W (N, 6) ↦ μ·W (N, 6) at these positions, without clamps."""
    chain, friction = scene.chain, scene.friction
    if friction.kind == "one-body":
        return lambda wrenches: wrenches / np.repeat(scene.drag, 3)
    reach = None if friction.neighbours == "all" else friction.neighbours
    fluid = chain.radius, chain.viscosity, scene.period
    pairs = PairFriction(chain.particles, reach, *fluid, scene.pair_accuracy)

    def apply(wrenches: np.ndarray) -> np.ndarray:
        twists = np.zeros_like(wrenches)
        pairs.apply(positions, wrenches, twists)
        return twists

    return apply


def _constraint(
    mobility: Callable[[np.ndarray], np.ndarray], component: int, given: np.ndarray, balanced: bool
) -> np.ndarray:
    """f (N,) with μ f + u the same everywhere, and Σ f = 0; or with μ f + u = 0."""
    from scipy.sparse.linalg import LinearOperator, cg

    def shared(values: np.ndarray) -> np.ndarray:
        return values - values.mean() if balanced else values

    def apply(loads: np.ndarray) -> np.ndarray:
        wrenches = np.zeros((len(loads), 6))
        wrenches[:, component] = shared(loads)
        return shared(mobility(wrenches)[:, component])

    target = -shared(given)
    unit = np.zeros((len(given), 6))
    unit[0, component] = 1.0
    own, size = float(mobility(unit)[0, component]), float(np.abs(target).max())
    if size <= ROUNDING * float(np.abs(given).max()):
        return np.zeros_like(target)
    operator = LinearOperator((len(target),) * 2, matvec=lambda v: apply(v) / own, dtype=float)
    found, left = cg(operator, shared(target / size), rtol=ACCURACY, maxiter=10 * len(target))
    if left:
        raise FloatingPointError("the link forces of the straight chain do not converge")
    return shared(found) * (size / own)
