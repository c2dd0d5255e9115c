"""What a choice of effects leaves out, and how large it may become."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from nrchain.errors import SceneError
from nrchain.planning.scene_changes import all_pairs, all_sizes, keys_that_differ
from nrchain.scene.scene import Scene, load_scene

BREACH = 2.0
"""Neglected velocities above this many times those of the probe break the bound."""

WINDOW = 0.1
"""Part of a run within which the velocities of the probe are taken for those of a time."""


FRICTION = {"friction.kind": "pairwise", "friction.neighbours": "all"}
"""The keys of friction between all spheres."""


@dataclass(frozen=True)
class Forgone:
    """The cheapest set where the full model is taken: what it would save, and at what error.

    Attributes
    ----------
    left_out
        In words.
    work
        Of a right-hand side, over that of the full model, by count
        (:mod:`nrchain.planning.nominal_cost`).
    error
        Distance from the full model that is to be expected, in radii or radians, as for
        :attr:`Choice.bound`; None where no probe has told.
    until
        The time to which the probe followed it: the end of the run, or where it strayed by more
        than is allowed, where one of the two stopped, or as far as the probe went.
    carried
        Whether the probe ended before, so that the error is carried on from there.
    stops
        Why its run is expected to stop, if it is.
    """

    left_out: tuple[str, ...]
    work: float
    error: float | None
    until: float
    carried: bool = False
    stops: str = ""

    def line(self, tolerance: float, end: float) -> str:
        """Saving and error in one sentence."""
        told = (
            f"the cheapest set leaves out {', '.join(self.left_out)}: a right-hand side takes "
            f"{self.work:.2g} of the work"
        )
        if self.error is None:
            return f"{told}; how far it strays is not known"
        size = f"{self.error:.2g} radii or radians off"
        if self.carried:
            told += f", and poses are at most {size} (an estimate beyond t = {self.until:.4g})"
        elif self.error > tolerance and self.until < end:
            told += f", and poses are {size} by t = {self.until:.4g}"
        else:
            told += f", and poses are at most {size} (to t = {self.until:.4g})"
        told += f", {tolerance:g} allowed"
        return f"{told}; its run stops: {self.stops}" if self.stops else told


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
    end
        The end of the run that the choice was made for.
    sets
        Every key that was given another value than it had in the scene, with both.
    watched_until
        The time from which on nobody has looked whether the bound holds: that at which a run was
        resumed unwatched.
    work
        Of a right-hand side, over that of the full model, by count.
    forgone
        The cheapest set, where the full model is taken and there is another.
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
        """What was chosen, what it saves or would have, the keys set, what it neglects."""
        chosen = "the full model"
        if self.left_out:
            chosen = (
                f"left out {', '.join(self.left_out)}, at {self.work:.2g} of the work of a "
                "right-hand side of the full model"
            )
        told = [f"effects chosen: {chosen}; {self.reason}"]
        if self.forgone:
            told.append(self.forgone.line(self.tolerance, self.end))
        if self.sets:
            told.append(f"keys set by it: {', '.join(self.sets)}")
        if self.left_out:
            how = f"to t = {self.probed:.4g}"
            if self.probed < self.end:
                how = f"an estimate beyond t = {self.probed:.4g}, to which the probe went"
            told.append(
                f"neglected: at most {self.bound:.2g} radii or radians from the full model ({how}),"
                f" {self.tolerance:g} allowed"
            )
        if math.isfinite(self.watched_until):
            told.append(
                f"not watched from t = {self.watched_until:.4g} on: no bound is known there"
            )
        return told

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
    """The scene with all its hydrodynamics: all pairs, finite size, friction between spheres.

    Without the latter where the scene allows none: see :func:`missing_friction`.
    """
    keys: dict[str, Any] = {"effects": "named", "tolerance": None}
    keys |= all_pairs(scene) | all_sizes(scene)
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
    """The keys that make of one scene the other, as a scene in Python names them."""
    return " and ".join(f"{key} = {new!r}" for key, _, new in keys_that_differ(scene, other))
