"""A trajectory as a labelled dataset of xarray, with the keys of its scene as attributes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from nrchain.inputs.arrays import GivenArray
from nrchain.inputs.optional import optional
from nrchain.scene.chain_sections import POSES
from nrchain.scene.scene import Scene
from nrchain.scene.toml import write_toml
from nrchain.version import __version__

if TYPE_CHECKING:
    import xarray

POSITION, FRAME = "position", "frame"
"""Variables of the dataset."""

_VARIABLES = {
    "positions": (POSITION, ("time", "sphere", "axis"), "centre of each sphere"),
    "frames": (FRAME, ("time", "sphere", "vector", "axis"), "frame of each sphere in the lab"),
    "position_error": ("position_error", ("time",), "estimated error, largest of all spheres"),
    "frame_error": ("frame_error", ("time",), "estimated error, largest of all spheres"),
}
"""Variable, dimensions and meaning of each series of a trajectory."""


def labelled_dataset(
    scene: Scene, series: Mapping[str, np.ndarray | None], **attributes: str
) -> xarray.Dataset:
    """The dataset of a run of ``scene``, with more attributes than its keys.

    ``series`` are the arrays of a trajectory by their names there: ``time``, ``positions``,
    ``frames``, ``position_error`` and ``frame_error``. They are not copied.
    """
    library = optional("xarray", "exchange", "a labelled dataset")
    length = f"unit of length of the scene, in which a sphere has radius {scene.chain.radius:g}"
    duration = f"unit of time of the scene, in which the viscosity is {scene.chain.viscosity:g}"
    variables: dict[str, Any] = {}
    for name, (variable, axes, what) in _VARIABLES.items():
        unit = {"frames": "1", "frame_error": "rad"}.get(name, length)
        if series[name] is not None:
            variables[variable] = axes, series[name], {"long_name": what, "units": unit}
    rest = scene.chain.spacing * np.arange(scene.chain.particles)
    places = {"long_name": "place along the chain at rest", "units": length}
    coordinates = {
        "time": ("time", series["time"], {"units": duration}),
        "sphere": ("sphere", np.arange(scene.chain.particles), {"long_name": "along the chain"}),
        "arclength": ("sphere", rest, places),
        "axis": ["x", "y", "z"],
        "vector": ["e1", "e2", "e3"],
    }
    return library.Dataset(variables, coordinates, {**_keys(scene), **attributes})


def keys_without_poses(scene: Scene) -> dict[str, Any]:
    """The raw table of a scene without the arrays of its start, which a trajectory holds itself."""
    table = scene.to_mapping()
    table["start"] = {name: value for name, value in table["start"].items() if name not in POSES}
    return table


def _keys(scene: Scene) -> dict[str, Any]:
    table = keys_without_poses(scene)
    return {**dict(_dotted(table)), "scene": write_toml(table), "nrchain": __version__}


def _dotted(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Each key by its dotted name, with a value that netCDF has attributes for."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from _dotted(value, f"{prefix}{name}.")
        elif isinstance(value, bool):
            yield prefix + name, int(value)
        elif isinstance(value, (tuple, list, GivenArray)):
            # an attribute has one axis
            yield prefix + name, np.ravel(np.asarray(value))
        else:
            yield prefix + name, value
