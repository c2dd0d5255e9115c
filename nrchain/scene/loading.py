"""A scene from a name, a file or a table, with changes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from nrchain.errors import SceneError
from nrchain.scene.scene import Scene
from nrchain.scene.toml import change, read_source


def load_scene(source: str | os.PathLike[str] | Mapping[str, Any] | Scene, **changes: Any) -> Scene:
    """The scene of a source, with changes made before it is checked.

    Parameters
    ----------
    source
        The name of a shipped scene, the path of a TOML file, a table with nested or dotted keys,
        or a scene.
    changes
        Dotted keys, ``**{"slip.2s": 50, "chain.spacing": 12}``, or sections,
        ``chain={"particles": 30}``. A section given as a table changes only the keys it names; a
        section given as an object (``chain=ChainSpec(...)``) replaces the whole. None removes a
        key: ``**{"elasticity.ratio": None}``.

    Raises :class:`~nrchain.errors.SceneError` for what cannot be found, read or simulated.

    >>> load_scene("buckling", **{"chain.particles": 20}).chain.particles
    20
    """
    if isinstance(source, Scene):
        table = source.to_mapping()
    elif isinstance(source, Mapping):
        table = dict(source)
    elif isinstance(source, (str, os.PathLike)):
        table = read_source(source)
    else:
        allowed = "must be the name of a shipped scene, a path, a table or a Scene"
        raise SceneError("scene", source, allowed)
    return Scene.from_mapping(change(table, changes))


def require_scene(given: Any) -> Scene:
    """The scene given. Anything else raises a SceneError that names :func:`load_scene`."""
    if not isinstance(given, Scene):
        allowed = "must be a Scene; load_scene makes one from a name, a path or a table"
        raise SceneError("scene", given, allowed)
    return given


def require_chosen(given: Any) -> Scene:
    """The scene given, which must name its effects: refused with ``effects = "auto"``."""
    scene = require_scene(given)
    if scene.effects == "auto":
        allowed = "must be chosen first: nrchain.auto.choose(scene)[0] names them"
        raise SceneError("effects", scene.effects, allowed)
    return scene
