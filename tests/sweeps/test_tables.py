"""The tables of a sweep: CSV, Parquet and netCDF hold the same, and other programs read them."""

import csv
import json
import sys

import numpy as np
import pytest

import nrchain
from nrchain.errors import MissingLibraryError

SCENE = nrchain.load_scene("buckling", **{"chain.particles": 4, "run.end": 0.5, "run.snapshots": 3})
OBSERVE = ["end.size", "measure.attractor", "end.error"]


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    folder = tmp_path_factory.mktemp("grid")
    values = {"slip.2s": [0.0, 50.0], "chain.ends": ["free", "clamped"]}
    return nrchain.sweep(SCENE, values, observe=OBSERVE, output=folder)


def test_a_row_has_keys_outcome_observables_cost_and_versions(grid):
    table = grid.table()
    assert {len(column) for column in table.values()} == {4}
    assert table["slip.2s"] == [0.0, 0.0, 50.0, 50.0]
    assert table["chain.ends"] == ["clamped", "free", "clamped", "free"]
    assert table["outcome"] == 4 * ["completed"]
    assert table["end.size"] == grid.column("end.size")
    for name in ("wall_time", "processor_time", "steps", "evaluations"):
        assert min(table[name]) > 0
    assert table["version.nrchain"] == 4 * [nrchain.__version__]
    # all keys of each scene, also those that no point changes
    for place, point in enumerate(grid.points):
        for section, keys in grid.scene_at(point).to_mapping().items():
            for key, value in keys.items() if isinstance(keys, dict) else ():
                assert table[f"{section}.{key}"][place] == value
    assert table["end.error"] == 4 * [None]
    assert all("run.verify" in why for why in table["unmeasured"])


def test_csv_and_parquet_hold_the_table(grid):
    parquet = pytest.importorskip("pyarrow.parquet")
    held = parquet.read_table(grid.folder / "table.parquet")
    assert held.to_pydict() == grid.table()
    assert nrchain.Scene.from_toml(held.schema.metadata[b"nrchain.scene"].decode()) == SCENE
    with (grid.folder / "table.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["end.size"]) for row in rows] == grid.column("end.size")
    assert [row["chain.ends"] for row in rows] == grid.column("chain.ends")


def test_pandas_reads_the_table(grid):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(grid.table())
    free = frame[(frame["slip.2s"] == 50.0) & (frame["chain.ends"] == "free")]
    assert free["end.size"].item() == grid.points[3].observables["end.size"]


def test_a_grid_is_a_dataset_over_its_keys(grid):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(grid.folder / "grid.nc", engine="h5netcdf") as held:
        assert dict(held.sizes) == {"slip.2s": 2, "chain.ends": 2}
        for point in grid.points:
            here = held.sel(point.values)
            assert here["end.size"].item() == point.observables["end.size"]
            assert here["measure.attractor"].item() == point.observables["measure.attractor"]
            assert np.isnan(here["end.error"].item())
        assert nrchain.Scene.from_toml(held.attrs["scene"]) == SCENE
        assert json.loads(held.attrs["versions"])["nrchain"] == [nrchain.__version__]


def test_points_that_fill_no_grid_lie_along_one_dimension(tmp_path):
    pytest.importorskip("xarray")
    points = [{"slip.2s": 1.0, "slip.3t": 5.0}, {"slip.2s": 2.0}]
    found = nrchain.sweep(SCENE, points=points, output=tmp_path)
    data = found.to_xarray()
    assert dict(data.sizes) == {"point": 2}
    assert data["slip.2s"].values.tolist() == [1.0, 2.0]
    assert np.isnan(data["slip.3t"].values[1])
    assert not (tmp_path / "grid.nc").exists()


def test_lists_and_kinds_that_differ_are_kept_as_text(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    values = {
        "slip.neighbours": [1, "all"],
        "slip.2s": [[1.0, 2.0, 3.0, 4.0], [4.0, 3.0, 2.0, 1.0]],
    }
    found = nrchain.sweep(SCENE, values, output=tmp_path)
    held = parquet.read_table(tmp_path / "table.parquet").to_pydict()
    assert sorted(set(held["slip.neighbours"])) == ["1", "all"]
    assert json.loads(held["slip.2s"][0]) == [1.0, 2.0, 3.0, 4.0]
    assert dict(found.to_xarray().sizes) == {"slip.neighbours": 2, "slip.2s": 2}


def test_without_the_libraries_the_ledger_and_a_csv_remain(tmp_path, monkeypatch):
    for name in ("pyarrow", "pyarrow.parquet", "h5netcdf", "xarray"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.warns(nrchain.SceneWarning, match=r"pip install 'nrchain\[sweep\]'"):
        found = nrchain.sweep(SCENE, {"slip.2s": [1.0]}, output=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "request.json",
        "results.jsonl",
        "table.csv",
    ]
    assert nrchain.Sweep.open(tmp_path) == found
    with pytest.raises(MissingLibraryError, match=r"xarray: pip install 'nrchain\[sweep\]'"):
        found.to_xarray()
