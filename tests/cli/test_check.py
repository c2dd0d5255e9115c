"""nrchain check lists what is wrong with a scene; nrchain scenes NAME writes one to start from."""

from __future__ import annotations

import json

import pytest
from support.command_line import assert_refused, call, program

import nrchain
from nrchain.cli.exits import REFUSED

WRONG = """
[chain]
particles = 10
spacin = 10
[slip]
2s = "a"
[run]
end = -1
"""


@pytest.fixture
def wrong(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(WRONG)
    return path


def test_all_mistakes_are_listed_with_what_is_meant(wrong):
    done = program("check", wrong, stdout=-1, env={"COLUMNS": "80"})
    assert (done.returncode, done.stderr) == (REFUSED, "")
    first, *rest = done.stdout.splitlines()
    assert first == f"{wrong}: 3 mistakes"
    text = " ".join(line.strip() for line in rest)
    assert "chain.spacin = 10: is not a known key" in text
    assert "did you mean 'spacing'?" in text
    assert "slip.2s = 'a': must be a finite number" in text
    assert "run.end = -1: must be a finite number, above 0" in text
    assert max(map(len, rest)) <= 80


def test_json_has_the_same_and_nothing_else(wrong):
    shown = call("check", wrong, "--json")
    assert (shown.exit_code, shown.stderr) == (REFUSED, "")
    record = json.loads(shown.stdout)
    assert [one["key"] for one in record["mistakes"]] == ["chain.spacin", "slip.2s", "run.end"]
    assert record["warnings"] == record["without_effect"] == []


def test_quiet_leaves_the_exit_code(wrong):
    shown = call("check", wrong, "-q")
    assert (shown.exit_code, shown.output) == (REFUSED, "")
    shown = call("check", "buckling", "--quiet")
    assert (shown.exit_code, shown.output) == (0, "")


def test_a_scene_without_mistakes_shows_its_risks():
    shown = call("check", "buckling")
    assert (shown.exit_code, shown.stdout) == (0, "buckling: no mistakes\n")
    shown = call("check", "buckling", "--set", "slip.2s=1e6", "--set", "steric.kind=none")
    assert shown.exit_code == 0
    assert "warning: out of the beam limit" in shown.stdout
    unused = call("check", "buckling", "--set", "start.shape=straight", "--set", "start.seed=3")
    assert "start.seed has no effect" in unused.stdout


def test_a_start_that_is_refused_is_a_mistake():
    changes = ("--set", "start.shape=sine", "--set", "start.amplitude=1e5", "--json")
    shown = call("check", "buckling", *changes)
    assert shown.exit_code == REFUSED
    assert len(json.loads(shown.stdout)["mistakes"]) == 1


@pytest.mark.parametrize("text", ["[chain\n", "\x00", "a = 1\na = 2"])
def test_a_file_that_is_no_toml_is_one_mistake(tmp_path, text):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    shown = call("check", path, "--json")
    assert shown.exit_code == REFUSED
    (mistake,) = json.loads(shown.stdout)["mistakes"]
    assert "must be valid TOML" in mistake["message"]


def test_a_printed_scene_is_the_scene(tmp_path):
    path = tmp_path / "my.toml"
    shown = call("scenes", "helix-left", "--set", "run.end=7.0")
    assert shown.exit_code == 0
    path.write_text(shown.stdout)
    assert nrchain.load_scene(path) == nrchain.load_scene("helix-left", **{"run.end": 7.0})


def test_the_list_of_scenes_for_scripts():
    listed = json.loads(call("scenes", "--json").stdout)["scenes"]
    assert [one["name"] for one in listed] == list(nrchain.scene_names())
    assert listed[0]["particles"] == nrchain.load_scene(listed[0]["name"]).chain.particles
    table = json.loads(call("scenes", "wave", "--json").stdout)
    assert nrchain.load_scene(table) == nrchain.load_scene("wave")


def test_unknown_scenes_and_changes_of_none_are_refused():
    assert_refused(call("scenes", "buckle"), "did you mean 'buckling'?")
    assert_refused(call("scenes", "--set", "run.end=1"), "name the scene as well")
