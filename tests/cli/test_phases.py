"""``nrchain phases``: its tables, its files, and what it refuses."""

import csv
import re
import signal
import subprocess
import sys
import time

import pytest
from support.command_line import assert_refused, call

import nrchain

SCENE = (
    *("buckling", "--set", "chain.particles=6", "--set", "elasticity.ratio=1e8"),
    *("--set", "start.amplitude=0.5", "--start", "random", "--levels", "0"),
)
AXES = ("--x", "slip.2s=0:1500:3", "--y", "slip.3t=0:2000:2")


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_regions_thresholds_and_files_are_shown(tmp_path):
    result = call("phases", *SCENE, *AXES)
    assert result.exit_code == 0, result.stderr
    folder = tmp_path / "runs" / "buckling-phases"
    found = nrchain.PhaseDiagram.open(folder)
    for region in found.regions:
        assert f"{100.0 * region.share:.1f} %" in result.stdout
    curve = found.curves[0]
    assert f"buckles on a curve from ({curve.x[0]:.6g}, {curve.y[0]:.6g})" in result.stdout
    assert "6 runs at 6 points" in result.stdout
    assert (folder / "phases.png").stat().st_size > 10_000
    with (folder / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == [point.kind for point in found.points]
    # the same command again finds all that it needs
    assert call("phases", *SCENE, *AXES).stdout == result.stdout


def test_an_interrupted_diagram_says_how_to_go_on(tmp_path):
    words = ["phases", *SCENE[:-1], "5", *AXES, "--most", "5000", "-o", "d"]
    with subprocess.Popen(
        [sys.executable, "-m", "nrchain", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        results, end = tmp_path / "d" / "results.jsonl", time.monotonic() + 120.0
        while time.monotonic() < end and not (results.exists() and results.stat().st_size):
            time.sleep(0.05)
        program.send_signal(signal.SIGINT)
        shown = program.communicate(timeout=60)
    assert program.returncode == 130
    assert shown[0] == ""
    *waiting, last = shown[1].splitlines()
    assert last == (
        "nrchain: interrupted; what is finished is kept in d; the same command continues"
    )
    # said at once, if runs are under way
    said = r"nrchain: interrupted; waiting for \d+ runs? under way to end at the next step"
    assert len(waiting) <= 1
    assert all(re.fullmatch(said, line) for line in waiting)
    assert not nrchain.PhaseDiagram.open(tmp_path / "d").is_complete


@pytest.mark.parametrize("axis", ["slip.2s", "slip.2s=1", "slip.2s=1:b", "slip.2s=0:1:2:3"])
def test_axes_that_cannot_be_read_are_refused(axis):
    refused = call("phases", *SCENE, "--x", axis, "--y", "slip.3t=0:1")
    assert_refused(refused, axis, "must be")


def test_other_input_is_refused_in_one_line():
    assert_refused(call("phases", *SCENE, "--x", "slip.9z=0:1", "--y", AXES[3]), "slip.9z")
    field = ("--set", "field.force=[0,0,1]")
    assert_refused(call("phases", *SCENE, *AXES, *field), "field", "does not move and rotate")
