"""What a choice of effects leaves out, and the bound of its error."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from nrchain.errors import SceneError
from nrchain.planning.flow_keys import all_pair_keys, differing_keys, finite_size_keys
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene

BREACH = 2.0
"""The bound breaks when neglected velocities exceed those of the probe by this factor."""

WINDOW = 0.1
"""Part of a run about a time from which the velocities of the probe are taken."""


FRICTION = {"friction.kind": "pairwise", "friction.neighbours": "all"}
"""The keys that set friction between all spheres."""


@dataclass(frozen=True)
class Forgone:
    """The cheapest set of effects where the full model is chosen: what it saves, and its error.

    Attributes
    ----------
    left_out
        The effects it leaves out, in words.
    work
        Work of a right-hand side over that of the full model, as counted by
        :mod:`nrchain.planning.counted_work`.
    error
        Expected distance from the full model, in radii or radians, as :attr:`Choice.bound`; None if
        no probe found it.
    until
        The time to which the probe followed it: the end of the run, the time at which it was
        too far off or one of the two stopped, or the time at which the probe ended.
    carried
        Whether the probe ended early, so that the error is extrapolated from there.
    stops
        Why its run would stop, if it would.
    """

    left_out: tuple[str, ...]
    work: float
    error: float | None
    until: float
    carried: bool = False
    stops: str = ""

    def line(self, tolerance: float, end: float) -> str:
        """Saving and error in one sentence."""
        text = (
            f"the cheapest set of effects leaves out {', '.join(self.left_out)}: a right-hand side "
            f"takes {self.work:.2g} of the work"
        )
        if self.error is None:
            return f"{text}; its error is not known"
        size = f"{self.error:.2g} radii or radians off"
        if self.carried:
            text += f", and poses are at most {size} (an estimate beyond t = {self.until:.4g})"
        elif self.error > tolerance and self.until < end:
            text += f", and poses are {size} by t = {self.until:.4g}"
        else:
            text += f", and poses are at most {size} (to t = {self.until:.4g})"
        text += f"; {tolerance:g} is allowed"
        return f"{text}; its run stops: {self.stops}" if self.stops else text


@dataclass(frozen=True)
class Choice:
    """The effects that ``effects = "auto"`` chose for a scene, and what they leave out.

    Attributes
    ----------
    tolerance
        The largest distance allowed, in radii and radians.
    left_out
        The effects left out, in words; empty for the full model.
    bound
        Largest expected distance from the full model, in radii or radians: 1.1 times that of the
        probe.
    probed
        The time to which the probe went; beyond it, the distance is extrapolated.
    times, velocities
        Times of the probe, and the largest neglected |Δv|/a or |Δω| of a sphere at each.
    reason
        Why this set, in words.
    end
        The end of the run that the choice was made for.
    sets
        Every key whose value the choice changed, with the old and the new value.
    watched_until
        The time from which the bound was not checked, because the run was resumed unwatched.
    work
        Work of a right-hand side over that of the full model, by count.
    forgone
        The cheapest set, if the full model was chosen and there is another.
    """

    tolerance: float
    left_out: tuple[str, ...]
    bound: float
    probed: float
    times: tuple[float, ...]
    velocities: tuple[float, ...]
    reason: str
    end: float = 0.0
    sets: tuple[str, ...] = ()
    watched_until: float = math.inf
    work: float = 1.0
    forgone: Forgone | None = None

    def to_json(self) -> str:
        return json.dumps(asdict(self), ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        table = json.loads(text)
        lists: dict[str, Any] = {
            name: tuple(table.get(name, ())) for name in ("left_out", "times", "velocities", "sets")
        }
        if forgone := table.get("forgone"):
            lists["forgone"] = Forgone(**(forgone | {"left_out": tuple(forgone["left_out"])}))
        return cls(**(table | lists))

    def lines(self) -> list[str]:
        """What was chosen, what that saves, the keys it sets and the error, a sentence each."""
        chosen = "the full model"
        if self.left_out:
            chosen = (
                f"left out {', '.join(self.left_out)}, at {self.work:.2g} of the work of a "
                "right-hand side of the full model"
            )
        sentences = [f"effects chosen: {chosen}; {self.reason}"]
        if self.forgone:
            sentences.append(self.forgone.line(self.tolerance, self.end))
        if self.sets:
            sentences.append(f"keys that the choice sets: {', '.join(self.sets)}")
        if self.left_out:
            how = f"to t = {self.probed:.4g}"
            if self.probed < self.end:
                how = f"an estimate beyond t = {self.probed:.4g}, where the probe ended"
            sentences.append(
                f"poses stay within {self.bound:.2g} radii or radians of the full model ({how});"
                f" {self.tolerance:g} is allowed"
            )
        if math.isfinite(self.watched_until):
            sentences.append(
                f"not watched from t = {self.watched_until:.4g} on: no bound holds there"
            )
        return sentences

    def allowed(self, time: float, end: float) -> float:
        """The neglected velocity, in radii or radians per unit time, above which the bound breaks.

        :data:`BREACH` times the largest of the probe about this time (beyond its end: of its second
        half) and the velocity that adds up to the tolerance over the whole run.
        """
        times, velocities = np.array(self.times), np.array(self.velocities)
        near = np.abs(times - time) <= WINDOW * end
        if not near.any():
            near = times >= 0.5 * times[-1]
        return BREACH * max(float(velocities[near].max()), self.tolerance / end)


def full_scene(scene: Scene) -> Scene:
    """The scene with all its hydrodynamics: all pairs, finite size, friction between spheres.

    Friction between spheres is left out if the scene cannot have it, see
    :func:`missing_friction`.
    """
    keys: dict[str, Any] = {"effects": "named", "tolerance": None}
    keys |= all_pair_keys(scene) | finite_size_keys(scene)
    if missing_friction(scene):
        return load_scene(scene, **keys)
    return load_scene(scene, **keys, **FRICTION)


def missing_friction(scene: Scene) -> str:
    """Why the full model of a scene has no friction between spheres; empty if it has."""
    try:
        load_scene(scene, effects="named", tolerance=None, **FRICTION)
    except SceneError as error:
        return str(error)
    return ""


def as_keys(scene: Scene, other: Scene) -> str:
    """The keys that turn one scene into the other, as Python writes them."""
    return " and ".join(f"{key} = {new!r}" for key, _, new in differing_keys(scene, other))
