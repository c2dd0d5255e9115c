"""p, and the scene with p changed: every number of a scene on which its motion depends.

The keys of the chain (spacing, radius, viscosity), of elasticity, the strengths of slip (of every
sphere where they differ), and all numbers of further effects. Keys that only choose a start or a
run have no effect on a state, and whole numbers and names are not varied.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.inputs.names import did_you_mean
from nrchain.scene.derived import DEFAULT_RATIO
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene


@dataclass(frozen=True)
class Parameter:
    """One number of a scene.

    Attributes
    ----------
    key
        Its dotted key; ``slip.2s[3]`` is the strength of sphere 3.
    value
        What it is.
    scale
        Its size, or that of its neighbours in a list: a change is small beside this.
    changed
        The scene with another value.
    """

    key: str
    value: float
    scale: float
    changed: Callable[[float], Scene]


def parameters(scene: Scene) -> tuple[Parameter, ...]:
    """The parameters of a scene, without zeros that stand alone or in a list of zeros."""
    return tuple(one for one in _every(scene) if one.scale)


def find_parameter(scene: Scene, key: str) -> Parameter:
    """The parameter of a key, also one that is 0, or the strength of a mode that is absent.

    Raises :class:`~nrchain.errors.SceneError` for any other key, with those that there are.
    """
    found = {one.key: one for one in _every(scene)}
    absent = [f"slip.{mode.label}" for mode in slip_modes.modes()]
    for name in absent:
        if not any(known.partition("[")[0] == name for known in found):
            found[name] = _parameter(scene, name, (), 0.0, lambda new: new)
    if key not in found:
        names = f"must be a number on which the motion depends: {', '.join(found)}"
        raise SceneError("key", key, names + did_you_mean(key, found))
    return found[key]


def _every(scene: Scene) -> list[Parameter]:
    """All numbers of a scene, zeros too."""
    given = scene.to_mapping()
    flat: dict[str, Any] = {
        f"chain.{name}": getattr(scene.chain, name) for name in ("spacing", "radius", "viscosity")
    }
    flat |= _elasticity(scene)
    for name in ("slip", *scene.further):
        flat |= {f"{name}.{key}": value for key, value in given.get(name, {}).items()}
    return [one for key, value in flat.items() for one in _of_key(scene, key, value)]


def _elasticity(scene: Scene) -> dict[str, float]:
    moduli, given = scene.moduli, scene.elasticity
    table = {"elasticity.twist": moduli.twist, "elasticity.bend": moduli.bend}
    if given.stretch is None:
        return {"elasticity.ratio": given.ratio or DEFAULT_RATIO, **table}
    return {"elasticity.stretch": moduli.stretch, "elasticity.shear": moduli.shear, **table}


def _of_key(scene: Scene, key: str, value: Any) -> Iterator[Parameter]:
    """The numbers in the value of a key: itself, or those in lists and tables."""
    if isinstance(value, Mapping):
        # a mode with an axis of its own: its strength is varied
        inner = value.get("strength")
        for one in _numbers(inner):
            yield _parameter(scene, key, one, inner, lambda new: {**value, "strength": new})
        return
    for one in _numbers(value):
        yield _parameter(scene, key, one, value, lambda new: new)


Path = tuple[int, ...]


def _numbers(value: Any, path: Path = ()) -> list[Path]:
    """Places of the floats in nested lists."""
    if isinstance(value, float):
        return [path]
    if isinstance(value, (list, tuple)):
        return [deep for k, item in enumerate(value) for deep in _numbers(item, (*path, k))]
    return []


def _parameter(
    scene: Scene, key: str, path: Path, value: Any, whole: Callable[[Any], Any]
) -> Parameter:
    name = key + "".join(f"[{k}]" for k in path)
    scale = max(abs(_at(value, place)) for place in _numbers(value))

    def changed(new: float) -> Scene:
        return load_scene(scene, **{key: whole(_with(value, path, new))})

    return Parameter(name, _at(value, path), scale, changed)


def _at(value: Any, path: Path) -> float:
    for place in path:
        value = value[place]
    return float(value)


def _with(value: Any, path: Path, new: float) -> Any:
    if not path:
        return new
    items = list(value)
    items[path[0]] = _with(items[path[0]], path[1:], new)
    return items
