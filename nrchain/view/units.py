"""The names of axes with their units: those of the paper where a scene has them.

The paper has a = 1 and μ⊥ = γ_T d² with γ_T = 6πηa. Times are then in units of γ_T d²/μ⊥, rates in
its inverse and velocities in a times that. A scene in other units has no unit to name: its numbers
are those of its keys.
"""

from __future__ import annotations

import math
from typing import Literal

from nrchain.scene.scene import Scene

Kind = Literal["time", "rate", "speed", "length"]

UNITS: dict[Kind, str] = {
    "time": r"\gamma_T d^2/\mu",
    "rate": r"\mu/\gamma_T d^2",
    "speed": r"a\,\mu/\gamma_T d^2",
    "length": "a",
}


def time_scale(scene: Scene) -> float:
    """γ_T d²/μ⊥ in the units of the scene; infinite without bending stiffness."""
    bend = scene.moduli.bend
    return scene.drag.translation * scene.chain.spacing**2 / bend if bend else math.inf


def has_unit(scene: Scene, kind: Kind) -> bool:
    """Whether the unit of the paper is 1 in a scene."""
    length = scene.chain.radius if kind in ("speed", "length") else 1.0
    time = 1.0 if kind == "length" else time_scale(scene)
    return math.isclose(time, 1.0, rel_tol=1e-9) and math.isclose(length, 1.0)


def label(symbol: str, scene: Scene, kind: Kind) -> str:
    """A symbol, in the notation of TeX, with its unit if the scene has that of the paper.

    >>> label("t", nrchain.load_scene("buckling"), "time")
    '$t$  [$\\\\gamma_T d^2/\\\\mu$]'
    """
    unit = f"  [${UNITS[kind]}$]" if has_unit(scene, kind) else ""
    return f"${symbol}${unit}"


def words(text: str, scene: Scene, kind: Kind) -> str:
    """A name in words with its unit if the scene has that of the paper."""
    return f"{text}  [${UNITS[kind]}$]" if has_unit(scene, kind) else text


def time_name(scene: Scene) -> str:
    """The unit of the paper for times, if the scene has it; empty without.

    >>> time_name(nrchain.load_scene("buckling"))
    'γ_T d²/μ'
    """
    return "γ_T d²/μ" if has_unit(scene, "time") else ""


def time_unit(scene: Scene) -> str:
    """In words: the unit of t if it is that of the paper, or else what γ_T d²/μ is.

    >>> time_unit(nrchain.load_scene("buckling"))
    't in units of γ_T d²/μ'
    >>> time_unit(nrchain.load_scene("buckling", **{"elasticity.bend": 1.0}))
    'γ_T d²/μ = 1885 units of t'
    """
    if has_unit(scene, "time"):
        return "t in units of γ_T d²/μ"
    unit = time_scale(scene)
    return f"γ_T d²/μ = {unit:.4g} units of t" if math.isfinite(unit) else ""
