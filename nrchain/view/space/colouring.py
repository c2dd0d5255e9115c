"""The quantity that colours a chain in space: of every sphere or of every link, over a film."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from nrchain.analysis.decomposition import Decomposition
from nrchain.analysis.link_strains import LinkStrains, link_strains
from nrchain.errors import SceneError
from nrchain.inputs.names import did_you_mean
from nrchain.inputs.rules import choice
from nrchain.trajectory.trajectory import Trajectory
from nrchain.view.shown import Spacing

PLAIN = "plain"
MOTIONS = ("speed", "spin")
STRAINS = LinkStrains._fields
EFFECT = "effect:"

DECADES = 4
"""Of a logarithmic scale, below the largest value."""

_UNITS = {"stretch": "", "shear": "", "bend": ", 1/length", "twist": ", 1/length"}


@dataclass(frozen=True)
class Colouring:
    """A quantity over a film.

    Attributes
    ----------
    values
        (F, N) of spheres, or (F, N − 1) of links; that which closes a periodic chain is left out.
    of
        Which of both.
    label
        What it is, with its unit.
    limits
        The values with the first and last colour: from 0, or symmetric about 0 where it is signed;
        the last :data:`DECADES` of a logarithmic scale.
    logarithmic
        Whether colours have even ratios.
    """

    values: np.ndarray
    of: Literal["spheres", "links"]
    label: str
    limits: tuple[float, float]
    logarithmic: bool = False

    @property
    def signed(self) -> bool:
        """Whether values lie on both sides of 0."""
        return self.limits[0] < 0.0


def colouring(trajectory: Trajectory, name: str, scale: Spacing = "linear") -> Colouring | None:
    """The quantity ``name`` at all snapshots of a trajectory; None for ``"plain"``.

    ``"speed"`` is |v|, ``"spin"`` |ω|, ``"stretch"``, ``"shear"``, ``"bend"`` and ``"twist"`` are
    strains of links (:func:`~nrchain.analysis.link_strains.link_strains`), and ``"effect:NAME"`` is
    √(|v|² + a²|ω|²) of what one effect contributes to the motion
    (:func:`nrchain.contributions`). A ``"logarithmic"`` scale shows sizes: signs are lost.

    Raises :class:`~nrchain.errors.SceneError` for another name.
    """
    choice(Spacing)("colour_scale", scale)
    if name == PLAIN:
        return None
    found = _linear(trajectory, name)
    if scale == "linear":
        return found
    most = max(abs(found.limits[0]), found.limits[1])
    least = 10.0**-DECADES * most
    sizes = np.maximum(np.abs(found.values), least)
    return replace(found, values=sizes, limits=(least, most), logarithmic=True)


def _linear(trajectory: Trajectory, name: str) -> Colouring:
    if name in STRAINS:
        strains = link_strains(trajectory.scene, trajectory.positions, trajectory.frames)
        values = getattr(strains, name)[:, : trajectory.scene.chain.particles - 1]
        return Colouring(values, "links", f"{name}{_UNITS[name]}", _limits(values))
    if name in MOTIONS or (isinstance(name, str) and name.startswith(EFFECT)):
        return _motion(trajectory, name)
    known = (PLAIN, *MOTIONS, *STRAINS)
    allowed = f"must be one of {', '.join(known)} or {EFFECT}NAME{did_you_mean(name, known)}"
    raise SceneError("colour", name, allowed)


def _motion(trajectory: Trajectory, name: str) -> Colouring:
    """|v|, |ω| or the size of the contribution of an effect to both, for every sphere."""
    parts, radius = Decomposition(trajectory.scene), trajectory.scene.chain.radius
    weights = {"speed": (1.0, 0.0), "spin": (0.0, 1.0)}.get(name, (1.0, radius))
    rows = []
    for positions, frames in zip(trajectory.positions, trajectory.frames, strict=True):
        found = parts.at(positions, frames)
        if name in MOTIONS:
            twist = found.total.twist
        else:
            effect = name.removeprefix(EFFECT)
            if effect not in found:
                known = ", ".join(EFFECT + one for one in found)
                raise SceneError("colour", name, f"the effects of this run are {known}")
            twist = found[effect].twist
        rows.append(np.linalg.norm(twist * np.repeat(weights, 3), axis=1))
    values = np.array(rows)
    label = name.removeprefix(EFFECT)
    units = {"speed": ", length/time", "spin": ", 1/time"}.get(name, ", length/time")
    return Colouring(values, "spheres", label + units, _limits(values))


def _limits(values: np.ndarray) -> tuple[float, float]:
    """From 0 to the largest value, or symmetric about 0; a range of 1 where nothing is there."""
    most = float(np.abs(values).max(initial=0.0)) or 1.0
    return (-most if values.min(initial=0.0) < 0.0 else 0.0), most
