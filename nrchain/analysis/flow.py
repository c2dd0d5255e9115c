"""u(x) = G·x + Σ_j u_j(x − r_j): the velocity and vorticity of the fluid about a chain.

u_j is the exact flow about sphere j by itself (:mod:`nrchain.hydrodynamics.point_flow`). Its parts:

    slip         the slip of its modes, of the scene and of a user
    forces       the force on it: elastic, steric, of fields and own effects, and of clamps
    torques      the torque on it, likewise
    background   the flow far from the chain, and the disturbance by rigid spheres

Every force on a sphere is a force on the fluid, since the motion is overdamped. With one-body
friction the fluid has its flow too, although other spheres do not feel it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from nrchain.effects.base import Effect
from nrchain.effects.flow import Flow as BackgroundFlow
from nrchain.effects.friction import FrictionBetweenSpheres
from nrchain.effects.registry import acting
from nrchain.effects.shared.image_sums import net_forces
from nrchain.effects.strain import DisturbanceEffect, Strain
from nrchain.errors import SceneError, TrajectoryError
from nrchain.hydrodynamics.given_slips import given_slips
from nrchain.hydrodynamics.point_flow import Spheres, sum_flows
from nrchain.inputs.arguments import finite_array
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import number
from nrchain.motion.model import Model
from nrchain.notebook import record_html
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.trajectory.trajectory import Snapshot, Trajectory
from nrchain.wording import brief

Part = Literal["slip", "forces", "torques", "background"]

PARTS: tuple[Part, ...] = get_args(Part)

ACCURACY = 1e-8
"""Largest error of flows that a tree sums, relative to the largest."""

BALANCED = 1e-9
"""Largest net force of a period, over the sum of the sizes of its forces: rounding."""


@dataclass(frozen=True, eq=False)
class Flow:
    """u and ∇ × u of the fluid at the points that :func:`flow` was given.

    Attributes
    ----------
    points
        (..., 3), in the lab.
    velocity
        (..., 3), in units of the scene; NaN inside a sphere.
    vorticity
        (..., 3), ∇ × u, likewise.
    left_out
        Names of acting effects whose flow is not known: own effects that give twists.
    """

    points: np.ndarray
    velocity: np.ndarray
    vorticity: np.ndarray
    left_out: tuple[str, ...] = ()

    __repr__ = brief
    _repr_html_ = record_html

    @property
    def speed(self) -> np.ndarray:
        """|u| (...)."""
        return np.linalg.norm(self.velocity, axis=-1)


def flow(
    source: Scene | Trajectory | Snapshot,
    points: Any,
    *,
    frame: int = -1,
    parts: Iterable[Part] | None = None,
    accuracy: float = ACCURACY,
) -> Flow:
    """u(x) = G·x + Σ_j u_j(x − r_j) and ∇ × u: the flow of the fluid at any points.

    Each sphere has its exact flow by itself, finite size included; what spheres reflect of the
    flows of others is left out. All spheres act on every point, whatever the reach of slip and
    friction along the chain. Points inside a sphere have no fluid: their flow is NaN. The fluid is
    unbounded. A periodic chain acts with all its images along x.

    Parameters
    ----------
    source
        A scene, at the poses from which it starts, a trajectory or one of its snapshots.
    points
        (..., 3), in the lab, in the unit of length of the scene.
    frame
        The snapshot of a trajectory, by its index; −1 is the last.
    parts
        Those of ``"slip"``, ``"forces"``, ``"torques"``, ``"background"`` that are summed; None:
        all.
    accuracy
        Largest error, relative to the largest flow, of sums over 5e7 pairs of spheres and points or
        more, which a tree takes over; 0 sums directly.

    Returns
    -------
    Flow
        ``velocity`` and ``vorticity``, (..., 3) each.

    Raises
    ------
    SceneError
        For points of a wrong shape, unknown parts, a snapshot that is not there, and the forces of
        a periodic chain that do not sum to zero: their flow over all images has no sum.

    >>> import nrchain
    >>> scene = nrchain.load_scene("buckling", **{"start.shape": "straight"})
    >>> found = nrchain.flow(scene, [[90.0, 3.0, 0.0], [90.0, 0.0, 4.0]], parts=["slip"])
    >>> found.velocity.shape, bool(found.velocity[0, 1] < 0)
    ((2, 3), True)
    """
    scene, positions, frames = poses_of(source, frame)
    places = _points(points)
    chosen = _parts(parts)
    accuracy = number(least=0)("accuracy", accuracy)
    spheres = _spheres(scene, positions, frames, chosen)
    flat = places.reshape(-1, 3)
    twists = sum_flows(spheres, flat, accuracy)
    if "background" in chosen and BackgroundFlow.acts(scene):
        gradient = BackgroundFlow.section(scene).matrix
        twists[:, :3] += flat @ gradient.T
        twists[:, 3:] += BackgroundFlow(scene).spin
    velocity, spin = twists[:, :3].reshape(places.shape), twists[:, 3:].reshape(places.shape)
    return Flow(places, velocity, 2.0 * spin, unknown_flows(scene))


def _spheres(
    scene: Scene, positions: np.ndarray, frames: np.ndarray, chosen: frozenset[str]
) -> Spheres:
    """The spheres of a chain, with what of them the chosen parts take."""
    chain = scene.chain
    slips = given_slips(scene.slip.modes, chain.particles) if "slip" in chosen else []
    wrenches = np.zeros((chain.particles, 6))
    if chosen & {"forces", "torques"}:
        whole = Model(scene).wrenches(unwrapped_chain(scene, positions), frames)
        for part, columns in (("forces", slice(0, 3)), ("torques", slice(3, 6))):
            if part in chosen:
                wrenches[:, columns] = whole[:, columns]
    _refuse_net_force(scene, wrenches)
    strain = np.zeros((3, 3))
    if "background" in chosen and Strain.acts(scene):
        gradient = BackgroundFlow.section(scene).matrix
        strain = 0.5 * (gradient + gradient.T)
    given = positions, frames, slips, wrenches, strain
    return Spheres(*given, chain.radius, chain.viscosity, scene.period)


def _refuse_net_force(scene: Scene, wrenches: np.ndarray) -> None:
    """Refuse forces whose flow over all images of a periodic chain has no sum."""
    if not scene.period or not (causes := net_forces(scene)):
        return
    forces = wrenches[:, :3]
    net, sizes = np.linalg.norm(forces.sum(axis=0)), np.linalg.norm(forces, axis=1).sum()
    if net <= BALANCED * sizes:
        return
    rest = ", ".join(repr(part) for part in PARTS if part != "forces")
    allowed = (
        f"has a net force ({', '.join(effect.name for effect in causes)}), whose flow over all"
        f" images of a periodic chain has no sum: name other parts, as parts = ({rest})"
    )
    raise SceneError("parts", "forces", allowed)


def unknown_flows(scene: Scene) -> tuple[str, ...]:
    """The acting effects that move spheres by a flow that is not known at other points."""
    known = (BackgroundFlow, DisturbanceEffect, FrictionBetweenSpheres)
    return tuple(effect.name for effect in acting(scene) if _is_unknown(effect, known))


def _is_unknown(effect: type[Effect], known: tuple[type[Effect], ...]) -> bool:
    return effect.gives != "wrench" and not effect.fused and not issubclass(effect, known)


def poses_of(source: Any, frame: int = -1) -> tuple[Scene, np.ndarray, np.ndarray]:
    """The scene, positions and frames of a scene's start, or of one snapshot.

    Errors as for :func:`flow`.
    """
    if isinstance(source, Scene | Snapshot):
        if frame not in (-1, 0):
            allowed = "must be 0 or −1 for a scene and a snapshot, which have one pose"
            raise SceneError("frame", frame, allowed)
        if isinstance(source, Scene):
            return (source, *initial_poses(source))
        return source.scene, source.positions, source.frames
    if not isinstance(source, Trajectory):
        raise SceneError("source", source, "must be a Scene, a Trajectory or a Snapshot")
    count = len(source.time)
    if not count:
        raise TrajectoryError("the trajectory has no finished snapshot")
    if isinstance(frame, bool) or not isinstance(frame, int | np.integer):
        raise SceneError("frame", frame, "must be a whole number")
    if not -count <= frame < count:
        allowed = f"must be from {-count} to {count - 1}: there are {count} snapshots"
        raise SceneError("frame", frame, allowed)
    return source.scene, source.positions[frame], source.frames[frame]


def _points(given: Any) -> np.ndarray:
    points = finite_array("points", given)
    if points.ndim == 0 or points.shape[-1] != 3:
        raise SceneError("points", points.shape, "the shape must be (..., 3)")
    return points


def _parts(given: Iterable[Part] | None) -> frozenset[str]:
    if given is None:
        return frozenset(PARTS)
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise SceneError("parts", given, f"must be a list of names among {', '.join(PARTS)}")
    found = tuple(given)
    for part in found:
        if part not in PARTS:
            hint = did_you_mean(part, PARTS)
            raise SceneError("parts", part, f"known parts are {', '.join(PARTS)}{hint}")
    return frozenset(found)
