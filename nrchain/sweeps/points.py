"""Grids, lists and random numbers → points: each a scene, loaded and checked before any is run."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import whole
from nrchain.planning.checked_start import starting_poses
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.scene.toml import flat_keys
from nrchain.sweeps.axes import read_ends, read_values, whole_numbers

SHOWN = 3
"""Points that are refused, of which a message shows so many."""

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Site:
    """One point to be run.

    Attributes
    ----------
    name
        Follows from all keys of its scene: equal scenes have one name, wherever they come from.
    values
        What is changed in the scene of the sweep.
    scene
        The scene with these changes.
    """

    name: str
    values: Values
    scene: Scene

    @classmethod
    def of(cls, scene: Scene, values: Values) -> Site:
        """The point of changes to a scene; its start is checked too. Raises SceneError."""
        changed = load_scene(scene, **values)
        if changed.effects != "auto":
            starting_poses(changed, None, None)
        return cls(name_of(changed), values, changed)


def name_of(scene: Scene) -> str:
    """Sixteen hexadecimal digits that follow from all keys of a scene."""
    text = json.dumps(portable(flat_keys(scene.to_mapping())), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def portable(value: Any) -> Any:
    """A value as JSON holds it: tuples and arrays become lists."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): portable(item) for key, item in value.items()}
    return [portable(item) for item in value] if isinstance(value, (list, tuple)) else value


def all_changes(
    scene: Scene,
    grid: Mapping[str, Any] | None,
    points: Iterable[Values] | None,
    random: Mapping[str, Any] | None,
    samples: int | None,
    seed: int,
) -> list[Values]:
    """Every combination of grid values, listed changes and random samples, in that order."""
    factors = [_grid(grid), _listed(points), _drawn(scene, random, samples, seed)]
    given = [factor for factor in factors if factor is not None]
    if not given:
        allowed = 'must name keys and values, such as {"slip.2s": [0, 50, 100]}'
        raise SceneError("grid", grid, allowed)
    changes: list[Values] = []
    for parts in itertools.product(*given):
        together: dict[str, Any] = {}
        for part in parts:
            _refuse_twice(together, part)
            together |= part
        changes.append(whole_numbers(scene, together))
    return changes


def sites(scene: Scene, changes: Sequence[Values]) -> list[Site]:
    """The points of all changes, each scene once.

    Raises :class:`~nrchain.errors.SceneError` that names the points whose scenes are refused.
    """
    good: dict[str, Site] = {}
    bad: list[tuple[Values, SceneError]] = []
    for values in changes:
        try:
            site = Site.of(scene, values)
            good.setdefault(site.name, site)
        except SceneError as error:
            bad.append((values, error))
    if bad:
        raise _refusal(bad, len(changes))
    return list(good.values())


def shown(values: Values) -> str:
    """The changes of a point in words, such as ``slip.2s = 100, chain.particles = 16``."""
    return ", ".join(
        f"{key} = {value:.6g}" if isinstance(value, float) else f"{key} = {value}"
        for key, value in values.items()
    )


def _refusal(bad: Sequence[tuple[Values, SceneError]], count: int) -> SceneError:
    first = bad[0][1]
    places = "; ".join(shown(values) for values, _ in bad[:SHOWN])
    more = f" and {len(bad) - SHOWN} more" if len(bad) > SHOWN else ""
    text = f"{first.allowed} (refused at {len(bad)} of {count} points: {places}{more})"
    return SceneError(first.key, first.value, text)


def _grid(grid: Mapping[str, Any] | None) -> list[Values] | None:
    if grid is None:
        return None
    if not isinstance(grid, Mapping) or not grid:
        allowed = 'must name keys and values, such as {"slip.2s": [0, 50, 100]}'
        raise SceneError("grid", grid, allowed)
    axes = {str(key): read_values(str(key), given) for key, given in grid.items()}
    return [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]


def _listed(points: Iterable[Values] | None) -> list[Values] | None:
    if points is None:
        return None
    allowed = 'must be a list of changes, such as [{"slip.2s": 50.0}, {"slip.2s": 80.0}]'
    if isinstance(points, (str, Mapping)) or not isinstance(points, Iterable):
        raise SceneError("points", points, allowed)
    listed = [dict(values) if isinstance(values, Mapping) else values for values in points]
    if not listed or not all(isinstance(values, dict) and values for values in listed):
        raise SceneError("points", listed, allowed)
    return [{str(key): portable(value) for key, value in values.items()} for values in listed]


def _drawn(
    scene: Scene, random: Mapping[str, Any] | None, samples: int | None, seed: int
) -> list[Values] | None:
    """Samples, drawn one after the other: more of them begin with the same ones."""
    if random is None:
        return None
    if not isinstance(random, Mapping) or not random:
        raise SceneError("random", random, 'must name keys and ends, such as {"slip.2s": (0, 100)}')
    count = whole(least=1)("samples", samples)
    ends = {str(key): read_ends("random", str(key), given) for key, given in random.items()}
    parts = np.random.default_rng(whole(least=0)("seed", seed)).random((count, len(ends)))
    integer = {key for key in ends if _takes_whole(scene, key, ends[key].low)}
    return [
        {
            key: ends[key].whole_at(float(part)) if key in integer else ends[key].at(float(part))
            for key, part in zip(ends, row, strict=True)
        }
        for row in parts
    ]


def _takes_whole(scene: Scene, key: str, low: float) -> bool:
    """Whether a key of the scene takes only whole numbers."""
    changed = whole_numbers(scene, {key: float(round(low))})
    return isinstance(changed[key], int)


def _refuse_twice(together: Values, part: Values) -> None:
    for key in part:
        if key in together:
            raise SceneError(key, part[key], "is varied twice; name a key once")
