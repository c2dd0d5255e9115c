"""Changes of a scene under which its chain holds: stiffer springs or weaker slip.

Each change is tried: the scene with it is judged in full, with twist, bend and touching spheres
(:func:`nrchain.planning.soundness.judge`). One key is tried before two, and two before four. Weaker
slip is tried if no stiffness helps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from nrchain.errors import SceneError
from nrchain.planning.soundness import judge
from nrchain.scene.derived import DEFAULT_RATIO
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene

LONG = 100
"""Above this many spheres fewer remedies are tried, and no least factor is searched for: a search
takes some two dozen judgements."""

FACTORS = (1e2, 1e4)
"""Factors of stiffness that are tried. Below the first that holds a smaller one is searched for."""

HALVINGS = 6
"""Halvings of the logarithm of a factor, which find it to 7 % between 1 and 100."""

WEAKEST = 1e-3
"""The smallest part of the strengths that is tried."""


def remedy(scene: Scene) -> str:
    """A change under which the chain holds, in words."""
    for keys in _candidates(scene):
        for factor in FACTORS:
            if holds(scene, _stiffer(scene, keys, factor)):
                found = _stiffer(scene, keys, _least(scene, keys, factor))
                return f"{_named(found)} {'hold' if len(found) > 1 else 'holds'} it"
    weaker = _strengths(scene)
    if weaker:
        return (
            f"no stiffness was found to hold it; {weaker:.2g} times these strengths of slip would"
        )
    return "no remedy was found: neither stiffer springs nor weaker slip hold it"


def holds(scene: Scene, changes: dict[str, Any]) -> bool:
    """Whether the changed scene is valid and its chain holds."""
    try:
        return judge(load_scene(scene, **changes)).sound
    except (SceneError, ArithmeticError):
        return False


def _candidates(scene: Scene) -> Iterator[tuple[str, ...]]:
    """Keys to raise together, fewest first."""
    own, angular = ("stretch", "shear"), ("twist", "bend")
    tried: list[tuple[str, ...]] = [("ratio",), ("bend",), ("ratio", "bend")]
    if scene.elasticity.stretch is not None:
        tried = [*((name,) for name in (*own, *angular)), own, angular, (*own, *angular)]
        if scene.chain.particles > LONG:
            tried = [own]
    elif scene.chain.particles > LONG:
        tried = [("ratio",)]
    present = _present(scene)
    yield from (names for names in tried if all(present[name] for name in names))


def _present(scene: Scene) -> dict[str, float]:
    """The moduli and the ratio of a scene, by the name of their key."""
    ratio = DEFAULT_RATIO if scene.elasticity.ratio is None else scene.elasticity.ratio
    return {**scene.moduli._asdict(), "ratio": ratio}


def _stiffer(scene: Scene, keys: tuple[str, ...], factor: float) -> dict[str, float]:
    present = _present(scene)
    return {f"elasticity.{name}": round_up(factor * present[name]) for name in keys}


def _least(scene: Scene, keys: tuple[str, ...], factor: float) -> float:
    """The smallest factor that holds, to the accuracy of the halvings."""
    index = FACTORS.index(factor)
    low, high = math.log(FACTORS[index - 1] if index else 1.0), math.log(factor)
    for _ in range(HALVINGS if scene.chain.particles <= LONG else 0):
        middle = 0.5 * (low + high)
        if holds(scene, _stiffer(scene, keys, math.exp(middle))):
            high = middle
        else:
            low = middle
    return math.exp(high)


def _strengths(scene: Scene) -> float:
    """The largest part of all strengths, of those tried, under which the chain holds; or 0."""
    part = 1.0
    while scene.slip.modes and part > WEAKEST:
        part = float(f"{0.7 * part:.1g}")
        if holds(scene, weakened(scene, part)):
            return part
    return 0.0


def weakened(scene: Scene, part: float) -> dict[str, Any]:
    """The changes that multiply each strength by ``part``."""
    changes: dict[str, Any] = {}
    for label, slip in scene.slip.modes.items():
        each = slip.strength
        changes[f"{SlipSpec.key(label)}.strength"] = (
            [part * one for one in each] if isinstance(each, tuple) else part * each
        )
    return changes


def _named(changes: dict[str, float]) -> str:
    return " and ".join(f"{key} = {value:g}" for key, value in changes.items())


def round_up(number: float) -> float:
    """The number rounded up to two digits."""
    if not number or not math.isfinite(number):
        return number
    step = 10.0 ** (math.floor(math.log10(number)) - 1)
    return float(f"{math.ceil(number / step * (1.0 - 1e-12)) * step:.2g}")
