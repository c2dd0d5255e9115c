"""A sweep as a table: CSV, Parquet, and netCDF of a grid."""

from __future__ import annotations

import csv
import itertools
import json
import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from nrchain.errors import MissingLibraryError
from nrchain.inputs.optional import optional
from nrchain.scene.scene import Scene
from nrchain.scene.toml import flat_keys
from nrchain.sweeps.points import portable
from nrchain.trajectory.file import file_errors

CSV, PARQUET, NETCDF = "table.csv", "table.parquet", "grid.nc"

EXTRA = "sweep"
"""What brings the libraries of Parquet and netCDF."""


class Points(Protocol):
    """What a table needs of a :class:`~nrchain.sweeps.result.Sweep`."""

    @property
    def scene(self) -> Scene: ...
    @property
    def keys(self) -> tuple[str, ...]: ...
    @property
    def points(self) -> tuple[Any, ...]: ...
    @property
    def observables(self) -> tuple[str, ...]: ...
    def column(self, name: str) -> list[Any]: ...
    def scene_at(self, point: Any) -> Scene: ...


def columns(sweep: Points) -> dict[str, list[Any]]:
    """The columns of a sweep by name, one row a point."""
    points = sweep.points
    found: dict[str, list[Any]] = {key: [p.values[key] for p in points] for key in sweep.keys}
    found |= {
        "outcome": [p.outcome for p in points],
        "cause": [p.cause for p in points],
        "reason": [p.reason for p in points],
    }
    found |= {name: sweep.column(name) for name in sweep.observables}
    found |= {
        "unmeasured": ["; ".join(f"{k}: {v}" for k, v in p.unmeasured.items()) for p in points],
        "warnings": ["; ".join(p.warnings) for p in points],
        "wall_time": [p.seconds for p in points],
        "processor_time": [p.processor_seconds for p in points],
    }
    for name in dict.fromkeys(name for p in points for name in p.counters):
        found[name] = [p.counters.get(name) for p in points]
    for name in dict.fromkeys(name for p in points for name in p.versions):
        found[f"version.{name}"] = [p.versions.get(name) for p in points]
    found["trajectory"] = [str(p.trajectory) if p.trajectory else None for p in points]
    found["name"] = [p.name for p in points]
    return found | _scene_columns(sweep)


def write_tables(sweep: Points, folder: Path) -> tuple[list[Path], list[str]]:
    """Write all tables of a sweep; return their paths, and what is missing for others, in words."""
    written, missing = [folder / CSV], []
    _write_csv(sweep, folder / CSV)
    further = [(folder / PARQUET, _write_parquet)]
    if grid_axes(sweep) is not None:
        further.append((folder / NETCDF, _write_netcdf))
    else:
        (folder / NETCDF).unlink(missing_ok=True)
    for path, write in further:
        try:
            write(sweep, path)
            written.append(path)
        except MissingLibraryError as error:
            missing.append(str(error))
    return written, missing


def grid_axes(sweep: Points) -> dict[str, list[Any]] | None:
    """The values of each key, if there is a point at every combination of them and no other."""
    axes = {key: _distinct(sweep.column(key)) for key in sweep.keys}
    if len(sweep.points) != math.prod(map(len, axes.values())):
        return None
    wanted = {json.dumps(values) for values in itertools.product(*axes.values())}
    held = {json.dumps([point.values[key] for key in sweep.keys]) for point in sweep.points}
    return axes if wanted == held else None


def to_dataset(sweep: Points) -> Any:
    """The ``xarray.Dataset`` of a sweep, over its keys if its points fill a grid."""
    xarray = optional("xarray", EXTRA, "a grid of results")
    axes = grid_axes(sweep)
    names = (*sweep.observables, "outcome", "wall_time", "evaluations")
    table = {name: values for name, values in columns(sweep).items() if name in names}
    attributes = {"scene": sweep.scene.to_toml(), "versions": json.dumps(_versions(sweep))}
    if axes is not None:
        # points are sorted by their values, as a grid is
        sizes = tuple(len(values) for values in axes.values())
        data = {n: (sweep.keys, _array(v).reshape(sizes)) for n, v in table.items()}
        coordinates = {key: _array(values) for key, values in axes.items()}
        return xarray.Dataset(data, coordinates, attributes)
    data = {name: (("point",), _array(values)) for name, values in table.items()}
    places = {key: ("point", _array(sweep.column(key))) for key in sweep.keys}
    return xarray.Dataset(data, places, attributes)


def _scene_columns(sweep: Points) -> dict[str, list[Any]]:
    """The keys of the scenes that the sweep does not vary."""
    rows = [portable(flat_keys(sweep.scene_at(point).to_mapping())) for point in sweep.points]
    keys = dict.fromkeys(key for row in rows for key in row if key not in sweep.keys)
    return {key: [row.get(key) for row in rows] for key in keys}


def _write_csv(sweep: Points, path: Path) -> None:
    table = {name: list(map(_text, values)) for name, values in columns(sweep).items()}
    with _replaced(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))


def _write_parquet(sweep: Points, path: Path) -> None:
    arrow = optional("pyarrow", EXTRA, "a Parquet table")
    parquet = optional("pyarrow.parquet", EXTRA, "a Parquet table")
    table = arrow.table({name: _uniform(values) for name, values in columns(sweep).items()})
    table = table.replace_schema_metadata(
        {"nrchain.scene": sweep.scene.to_toml(), "nrchain.keys": json.dumps(sweep.keys)}
    )
    with _replaced(path) as partial:
        parquet.write_table(table, partial)


def _write_netcdf(sweep: Points, path: Path) -> None:
    optional("h5netcdf", EXTRA, "a netCDF file")
    dataset = to_dataset(sweep)
    with _replaced(path) as partial:
        dataset.to_netcdf(partial, engine="h5netcdf")


@contextmanager
def _replaced(path: Path) -> Iterator[Path]:
    """A path to write to, which takes the place of ``path`` once it is whole."""
    partial = path.with_name(path.name + ".partial")
    with file_errors(path, "cannot be written"):
        yield partial
        os.replace(partial, path)


def _distinct(values: Sequence[Any]) -> list[Any]:
    return list({json.dumps(value): value for value in values}.values())


def _array(values: Sequence[Any]) -> np.ndarray:
    """Numbers, NaN where there is none; or words, empty where there is none."""
    if all(value is None or isinstance(value, (int, float)) for value in values):
        whole = all(isinstance(value, int) for value in values)
        kind = int if whole else float
        return np.array([np.nan if value is None else value for value in values], kind)
    return np.array(["" if value is None else _text(value) for value in values], object)


def _uniform(values: Sequence[Any]) -> list[Any]:
    """Values of one kind, for a column of Parquet: text where kinds are mixed."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    if len(kinds) > 1 or kinds & {list, dict}:
        return [None if value is None else _text(value) for value in values]
    return list(values)


def _text(value: Any) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _versions(sweep: Points) -> dict[str, list[str]]:
    """All versions of each package that some point ran with."""
    found: dict[str, list[str]] = {}
    for point in sweep.points:
        for package, version in point.versions.items():
            held = found.setdefault(package, [])
            if version not in held:
                held.append(version)
    return found
