"""``nrchain sweep``: its tables and pictures, and what it refuses."""

import csv
import json
import signal
import subprocess
import sys
import time

import pytest
from support.command_line import assert_refused, call

import nrchain

SCENE = (
    *("buckling", "--set", "chain.particles=5", "--set", "run.end=2", "--set", "run.snapshots=6"),
    *("--set", "elasticity.ratio=1e8"),
)
GRID = ("--grid", "slip.2s=-100:100:3", "--grid", "chain.particles=4,5")


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_grid_is_run_tabulated_and_drawn(tmp_path):
    observe = ("--observe", "end.size,measure.rate", "--observe", "measure.attractor")
    result = call("sweep", *SCENE, *GRID, *observe, "-o", "d")
    assert result.exit_code == 0, result.stderr
    found = nrchain.Sweep.open(tmp_path / "d")
    with (tmp_path / "d" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found) == 6
    for row, point in zip(rows, found.points, strict=True):
        assert float(row["slip.2s"]) == point.values["slip.2s"]
        assert float(row["end.size"]) == point.observables["end.size"]
        assert row["measure.attractor"] == point.observables["measure.attractor"]
        assert (row["outcome"], row["run.end"]) == ("completed", "2.0")
        assert row["version.nrchain"] == nrchain.__version__
    picture = tmp_path / "map.png"
    drawn = call(
        *("sweep", "show", "d", "--observe", "end.size", "--observe", "measure.attractor"),
        *("--x", "slip.2s", "--y", "chain.particles", "-o", picture),
    )
    assert drawn.exit_code == 0, drawn.stderr
    assert picture.stat().st_size > 5_000
    assert_refused(call("sweep", "show", "d", "-o", picture), "exists")
    again = call("sweep", "show", "d", "--y", "chain.particles", "--json")
    assert json.loads(again.stdout) == {"picture": "d/sweep.png", "at": {}, "without_value": []}
    assert call("sweep", "show", "d", "-q").stdout == ""


def test_an_observable_without_a_value_is_told_with_its_cause():
    observed = ("--observe", "end.size,end.error", "-o", "d")
    shown = call("sweep", *SCENE, *GRID, *observed)
    lines = "no value    end.error at 6 of 6 points; most often: the run has no estimate of\n"
    lines += "            its error; set run.verify = true\n"
    assert lines in shown.stdout
    assert "end.size at" not in shown.stdout
    drawn = call("sweep", "show", "d", "--observe", "end.error")
    assert drawn.stdout.endswith(lines)
    record = json.loads(call("sweep", "show", "d", "--observe", "end.error", "--json").stdout)
    assert [(one["name"], one["points"]) for one in record["without_value"]] == [("end.error", 6)]


def test_shards_are_merged_by_the_same_command():
    for part in ("1/2", "2/2"):
        shown = call("sweep", *SCENE, *GRID, "-o", "d", "--shard", part)
        assert shown.exit_code == 0, shown.stderr
        assert "without --shard" in shown.stdout
    merged = call("sweep", *SCENE, *GRID, "-o", "d")
    assert "points      6 points\n" in merged.stdout
    assert nrchain.Sweep.open("d") == nrchain.sweep(
        nrchain.load_scene(
            "buckling",
            **{"chain.particles": 5, "run.end": 2.0, "run.snapshots": 6, "elasticity.ratio": 1e8},
        ),
        {"slip.2s": "-100:100:3", "chain.particles": [4, 5]},
    )


def test_points_of_a_table_and_random_ones(tmp_path):
    (tmp_path / "points.csv").write_text("slip.2s, chain.ends\n50, free\n-20.5, clamped\n")
    shown = call("sweep", *SCENE, "--points", "points.csv", "-o", "d")
    assert shown.exit_code == 0, shown.stderr
    assert nrchain.Sweep.open("d").column("chain.ends") == ["clamped", "free"]
    random = ("--random", "slip.2s=-50:50", "--samples", "3", "--seed", "1")
    assert call("sweep", *SCENE, *random, "-o", "r").exit_code == 0
    drawn = sorted(nrchain.Sweep.open("r").column("slip.2s"))
    assert len(drawn) == 3
    assert -50.0 < drawn[0] < drawn[-1] < 50.0


def test_an_interrupted_sweep_says_how_to_go_on(tmp_path):
    words = ["sweep", *SCENE, "--grid", "slip.2s=0:1000:800", "-o", "d"]
    with subprocess.Popen(
        [sys.executable, "-m", "nrchain", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        results, end = tmp_path / "d" / "results.jsonl", time.monotonic() + 120.0
        while time.monotonic() < end and not (results.exists() and results.stat().st_size):
            time.sleep(0.05)
        running.send_signal(signal.SIGINT)
        shown = running.communicate(timeout=60)
    assert running.returncode == 130
    assert shown == (
        "",
        "nrchain: interrupted; what is finished is kept in d; the same command continues\n",
    )
    assert 0 < len(nrchain.Sweep.open(tmp_path / "d")) < 800


def test_failures_are_listed_with_their_cause(tmp_path):
    assert call("sweep", *SCENE, "--grid", "slip.2s=1", "-o", "d").exit_code == 0
    results = tmp_path / "d" / "results.jsonl"
    line = json.loads(results.read_text())
    results.write_text(
        json.dumps({k: line[k] for k in ("name", "point")} | {"failed": "why"}) + "\n"
    )
    shown = call("sweep", *SCENE, "--grid", "slip.2s=1", "-o", "d")
    assert "points      1 points, 1 failed\nfailed      slip.2s = 1: why\n" in shown.stdout
    again = call("sweep", *SCENE, "--grid", "slip.2s=1", "-o", "d", "--retry")
    assert "points      1 points\n" in again.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--grid", "slip.2s"), "slip.2s=-100:100:21"),
        (("--grid", "slip.2s=0:1"), "low:high:count"),
        (("--grid", "slip.2s=1", "--grid", "slip.2s=2"), "a second time"),
        (("--grid", "slip.9z=0:1:2"), "slip.9z"),
        (("--grid", "chain.particles=1,5"), "refused at 1 of 2 points: chain.particles = 1"),
        (("--grid", "slip.2s=1", "--observe", "end.syze"), "did you mean 'end.size'"),
        (("--grid", "slip.2s=1", "--shard", "3/2"), "shard"),
        (("--grid", "slip.2s=1", "--cluster", "no.json"), "no.json"),
        (("--random", "slip.2s=0:1"), "samples"),
        (("--points", "none.csv"), "none.csv"),
        ((), "--grid is not given: must name a key and its values, such as --grid slip.2s="),
        (("--adaptive", "slip.2s=0:1"), "--samples is not given"),
        (("--grid", "slip.2s=-1:10:3:log"), "--grid slip.2s = '-1:10:3:log': both ends of"),
        (("--grid", "slip.2s=0:1:0"), "the count, which is the third number, must be at least 1"),
        (("--random", "slip.2s=0:1:log", "--samples", "3"), "must be above 0"),
    ],
)
def test_other_input_is_refused_in_one_line(words, said, tmp_path):
    assert_refused(call("sweep", *SCENE, *words, "-o", "d"), said)
    assert not (tmp_path / "d").exists()


def test_what_cannot_be_drawn_is_refused(tmp_path):
    assert_refused(call("sweep", "show"), "FOLDER")
    assert_refused(call("sweep", "show", "none"), "there is no sweep")
    assert call("sweep", *SCENE, "--grid", "slip.2s=1", "-o", "d").exit_code == 0
    assert_refused(call("sweep", "show", "d", "--x", "slip.3t"), "x = 'slip.3t'", "slip.2s")
    assert_refused(call("sweep", "show", "d", "--observe", "end.energy"), "end.size")
    assert_refused(call("sweep", "show", "d", "-o", "a.txt"), ".png")
