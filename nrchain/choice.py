"""What a choice of effects leaves out, how large it is, and the watch that a run keeps on it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.effects.slip import active_modes
from nrchain.guard import Poses
from nrchain.model import Model
from nrchain.outcome import Cause, Stop
from nrchain.scene import Scene, load_scene
from nrchain.scene_changes import has_finite_size

BREACH = 2.0
"""Neglected velocities above this many times those of the probe break the bound."""

CHECKS = 10
"""How often a run compares what it neglects with what was foreseen, at most."""

WINDOW = 0.1
"""Part of a run within which the velocities of the probe are taken for those of a time."""


@dataclass(frozen=True)
class Choice:
    """The effects a scene was given by ``effects = "auto"``, and what they leave out.

    Attributes
    ----------
    tolerance
        What was allowed: radii, and radians.
    left_out
        In words; empty for the full model.
    bound
        Largest distance from the full model that is to be expected, in radii or radians: what the
        probe found, and a tenth.
    probed
        The time up to which the probe looked; beyond it, the distance is carried on.
    times, velocities
        Largest neglected |Δv|/a or |Δω| of a sphere along the probe, by its times.
    reason
        Why this set, in words.
    """

    tolerance: float
    left_out: tuple[str, ...]
    bound: float
    probed: float
    times: tuple[float, ...]
    velocities: tuple[float, ...]
    reason: str

    def to_json(self) -> str:
        return json.dumps(asdict(self), ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        table = json.loads(text)
        lists = {name: tuple(table[name]) for name in ("left_out", "times", "velocities")}
        return cls(**(table | lists))

    def lines(self) -> list[str]:
        """What was chosen and what it neglects, in sentences."""
        if not self.left_out:
            return [f"effects chosen: the full model; {self.reason}"]
        how = "" if not self.times or self.probed >= self.times[-1] else "an estimate beyond "
        how = f" ({how}t = {self.probed:.4g})" if how else ""
        return [
            f"effects chosen: left out {', '.join(self.left_out)}; {self.reason}",
            f"neglected: at most {self.bound:.2g} radii or radians from the full model{how}, "
            f"{self.tolerance:g} allowed",
        ]

    def allowed(self, time: float, end: float) -> float:
        """The neglected velocity, in radii or radians per unit time, that breaks the bound.

        That of the probe about this time, or of its second half beyond its end; and in any case
        what makes up the tolerance over the whole run.
        """
        times, velocities = np.array(self.times), np.array(self.velocities)
        near = np.abs(times - time) <= WINDOW * end
        if not near.any():
            near = times >= 0.5 * times[-1]
        return BREACH * max(float(velocities[near].max()), self.tolerance / end)


def full_scene(scene: Scene) -> Scene:
    """The scene with all its hydrodynamics: all pairs, finite size, friction between spheres."""
    keys: dict[str, Any] = {"effects": "named", "tolerance": None}
    if active_modes(scene):
        keys |= {"slip.neighbours": "all", "slip.finite_size": has_finite_size(scene)}
    return load_scene(scene, **keys, **{"friction.kind": "pairwise", "friction.neighbours": "all"})


class Watch:
    """Compares, at snapshots of a run, what its choice neglects with what the probe found.

    At :data:`CHECKS` of them at most: each takes a right-hand side of the full model.
    """

    def __init__(self, scene: Scene, choice: Choice | None, model: Model) -> None:
        self._choice = choice if choice and choice.left_out else None
        if self._choice:
            self._end, self._radius = scene.run.end, scene.chain.radius
            self._models = model, Model(full_scene(scene))
            self._next = 0.0

    def check(self, time: float, poses: Poses) -> None:
        """Raise :class:`~nrchain.outcome.Stop` if the bound is broken at these poses."""
        if self._choice is None or time < self._next:
            return
        self._next = time + self._end / CHECKS
        found = velocity_difference(*self._models, poses, self._radius)
        allowed = self._choice.allowed(time, self._end)
        if found > allowed:
            raise Stop(
                Cause.NEGLECTED,
                time,
                f"what is left out moves a sphere by {found:.3g} radii or radians per unit time, "
                f"and {allowed:.3g} was foreseen",
            )


def velocity_difference(model: Model, other: Model, poses: Poses, radius: float) -> float:
    """max of |v − v′|/a and |ω − ω′| over the spheres, at the same poses."""
    with np.errstate(all="ignore"):
        return largest_velocity(model.twists(*poses) - other.twists(*poses), radius) / radius
