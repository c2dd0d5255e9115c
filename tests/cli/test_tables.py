"""The tables of ``nrchain plan``, ``scenes``, ``effects`` and ``cost``."""

import sys
from io import StringIO

from support.command_line import assert_refused, call

from nrchain.accuracy.cost import Point, WorkPrecision
from nrchain.accuracy.timing import Measured
from nrchain.cli.tables import work_table
from nrchain.cli.terminal import print_output
from nrchain.run.work import RunCost, Work
from nrchain.scene.loading import load_scene
from nrchain.scene.toml import scene_names


def test_plan_writes_nothing_and_warns(tmp_path, stub, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = call("plan", "buckling", "--set", "chain.particles=64")
    assert result.exit_code == 0, result.stderr
    for part in (
        "closest approach",
        "stretch",
        "growth",
        "reach",
        "slip 2s",
        "displaced, rotated:",
    ):
        assert part in result.stdout
    assert "warning: out of the beam limit" in result.stderr
    assert stub.scene is None
    assert not any(tmp_path.iterdir())
    early = call("plan", "buckling", "--set", "chain.particles=8", "--budget", "0.01")
    assert "where the probe ended; the end is not known" in early.stdout
    assert_refused(call("plan", "bucklin"), "did you mean 'buckling'")


def test_scenes_lists_every_scene():
    result = call("scenes")
    assert result.exit_code == 0
    rows = result.stdout.splitlines()
    for name in scene_names():
        row = next(row for row in rows if row.strip().startswith(f"{name} "))
        scene = load_scene(name)
        assert scene.chain.ends in row
        assert str(scene.chain.particles) in row
        assert scene.title.split()[0] in row


def test_effects_are_listed_with_their_keys():
    from nrchain.effects.registry import effects

    shown = call("effects").stdout
    for effect in effects():
        assert effect.name in shown
        assert effect.key in shown


def test_the_table_of_costs_is_never_cut(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    counts = Work(12345678, 23456789, 34567890, 45678901)
    measured = Measured(1e-3, 1e-3, counts, (0.0123,), 0.5, 1.0)
    points = [Point("model", "… and pairwise friction", {}, measured)]
    own = RunCost(counts, 0.0123, 1.0, 400.0)
    found = WorkPrecision(load_scene("passive"), 1.0, own, points, "cvode", 1e-9)
    shown = StringIO()
    monkeypatch.setattr(sys, "stdout", shown)
    assert print_output(work_table(found), whole=True) is None
    for number in ("1.0e-03", "0.012", *map(str, counts), "not known"):
        assert number in shown.getvalue()
