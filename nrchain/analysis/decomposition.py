"""(v, ω)_i = Σ_effects (v, ω)_i: the wrench and the twist of each effect.

Each mode of slip is its leading-order flow at nearest neighbours, ``finite size`` the part of order
(a/r)² of that, and ``reach`` all slip flows from farther neighbours. The disturbance of a
background flow is ``strain`` and ``finite size of strain``, over its own reach. The twist of a
wrench is that of a sphere alone, W/γ; ``friction between spheres`` is the rest of the mobility, and
``support`` what the clamps add, through the same mobility. The sum is the motion of the simulation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.effects.base import Effect
from nrchain.effects.friction import FrictionBetweenSpheres
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.inputs.names import Named, unknown_name
from nrchain.motion.model import Model
from nrchain.notebook import record_html, table_html
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.scene.unwrapping import unwrapped_chain
from nrchain.trajectory.trajectory import Trajectory
from nrchain.wording import brief

SUPPORT = "support"


@dataclass(frozen=True, eq=False)
class Contribution:
    """The ``wrench`` (F, T) and ``twist`` (v, ω) of one effect, (N, 6) each, in the lab frame."""

    wrench: np.ndarray
    twist: np.ndarray

    __repr__ = brief
    _repr_html_ = record_html

    def size(self, radius: float) -> float:
        """√⟨|v|² + a²|ω|²⟩ of its twist, over the spheres."""
        scaled = self.twist * np.repeat([1.0, radius], 3)
        return float(np.sqrt((scaled**2).sum(axis=1).mean()))


@dataclass(frozen=True, eq=False)
class Contributions(Mapping[str, Contribution]):
    """The contributions at one pose of a chain, by the name of the effect, and their ``total``.

    The total is computed as in a simulation; the contributions add up to it, up to rounding.

    >>> import nrchain
    >>> scene = nrchain.load_scene("passive", **{"chain.particles": 3, "run.end": 1.0})
    >>> run = nrchain.simulate(scene)
    >>> found = nrchain.contributions(scene, run.positions[-1], run.frames[-1])
    >>> found["bend"].wrench.shape, found.total.twist.shape
    ((3, 6), (3, 6))
    """

    effects: dict[str, Contribution]
    total: Contribution

    def __getitem__(self, name: str) -> Contribution:
        if name not in self.effects:
            raise unknown_name(name, self.effects)
        return self.effects[name]

    def __repr__(self) -> str:
        return f"<Contributions to {len(self.total.twist)} spheres: {', '.join(self.effects)}>"

    def _repr_html_(self) -> str:
        rows = []
        for name, one in [*self.effects.items(), ("total", self.total)]:
            largest = (
                float(np.abs(one.twist[:, part]).max()) for part in np.split(np.arange(6), 2)
            )
            rows.append((name, *largest))
        heads = ("effect", "largest velocity", "largest angular velocity")
        return table_html(f"Contributions to {len(self.total.twist)} spheres", rows, heads)

    def __iter__(self) -> Iterator[str]:
        return iter(self.effects)

    def __len__(self) -> int:
        return len(self.effects)


class Decomposition:
    """The contributions of a scene at any poses: see :func:`contributions`."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._model = scene, Model(scene)
        self._radius = scene.chain.radius
        self._drag = np.repeat(scene.drag, 3)
        self._parts: list[Effect] = [
            effect(scene) for effect in self._model.effects if effect.gives != "mobility"
        ]

    def at(self, positions: np.ndarray, frames: np.ndarray) -> Contributions:
        """The contributions at positions (N, 3) and frames (N, 3, 3)."""
        positions = unwrapped_chain(self._scene, positions)
        model, found = self._model, {}
        nothing = np.zeros((model.count, 6))
        applied = nothing.copy()
        for part in self._parts:
            out = np.zeros((model.count, 6))
            if part.gives == "wrench":
                part.add_wrenches(positions, frames, out)
                applied += out
                found[part.name] = Contribution(out, out / self._drag)
            else:
                part.add_twists(positions, frames, out)
                found[part.name] = Contribution(nothing, out)
        total = Contribution(model.wrenches(positions, frames), model.twists(positions, frames))
        if model.friction is not None:
            through_fluid = model.mobile_twists(positions, applied) - applied / self._drag
            found[FrictionBetweenSpheres.name] = Contribution(nothing, through_fluid)
        if model.held.any():
            support = np.where(model.held[:, None], total.wrench - applied, 0.0)
            found[SUPPORT] = Contribution(support, model.mobile_twists(positions, support))
        return Contributions(found, total)

    def sizes(self, trajectory: Trajectory) -> dict[str, np.ndarray]:
        """√⟨|v|² + a²|ω|²⟩ (T,) of every contribution and of their ``total``, over time."""
        rows: list[dict[str, float]] = []
        for positions, frames in zip(trajectory.positions, trajectory.frames, strict=True):
            found = self.at(positions, frames)
            row = {name: part.size(self._radius) for name, part in found.items()}
            rows.append(row | {"total": found.total.size(self._radius)})
        names = rows[0] if rows else ()
        return Named({name: np.array([row[name] for row in rows]) for name in names})


def contributions(scene: Scene, positions: Any, frames: Any) -> Contributions:
    """The wrench and twist (N, 6) of every effect of a scene, and of all together.

    Parameters
    ----------
    scene
        The scene whose effects act.
    positions, frames
        (N, 3) and (N, 3, 3); ``frames[i, k]`` is e_{k+1} of sphere i in lab components. Positions
        of a periodic chain may be wrapped (:func:`nrchain.scene.unwrapping.unwrapped`).

    Returns
    -------
    Contributions
        ``found["slip 2s"].twist``, ``found["bend"].wrench``, … and ``found.total``.

    Raises :class:`~nrchain.errors.SceneError` for poses of the wrong shape or not valid, and for
    wrapped positions whose image is not clear.

    >>> from nrchain import load_scene, simulate
    >>> run = simulate(load_scene("buckling", **{"chain.particles": 4, "run.end": 1.0}))
    >>> found = contributions(run.scene, run.positions[-1], run.frames[-1])
    >>> found["slip 2s"].twist.shape
    (4, 6)
    """
    count = require_scene(scene).chain.particles
    poses = finite_array("positions", positions, (count, 3)), rotations(frames, count)
    return Decomposition(scene).at(*poses)


def contribution_sizes(trajectory: Trajectory) -> dict[str, np.ndarray]:
    """√⟨|v|² + a²|ω|²⟩ (T,) of the twist of every effect at the snapshots of a trajectory.

    By the name of the effect; ``"total"`` is the motion itself.

    >>> from nrchain import load_scene, simulate
    >>> run = simulate(load_scene("buckling", **{"chain.particles": 4, "run.end": 1.0}))
    >>> contribution_sizes(run)["slip 2s"].shape == run.time.shape
    True
    """
    return Decomposition(trajectory.scene).sizes(trajectory)
