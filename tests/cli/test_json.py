"""--json prints one object with the documented keys and nothing else; -q prints nothing."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from support.command_line import assert_refused, call
from support.selection import few_of

import nrchain
from nrchain.cli.exits import REFUSED, STOPPED
from nrchain.cli.records import json_text
from nrchain.trajectory.trajectory import Trajectory

RUNNING = Path(nrchain.__file__).parents[1] / "docs" / "running.md"
FEW = ("--set", "chain.particles=5", "--set", "run.end=1.0", "--set", "run.snapshots=3")

COMMANDS = {
    "run": ("buckling", *FEW, "-o", "run"),
    "resume": ("run",),
    "check": ("buckling",),
    "scenes": (),
    "effects": (),
    "plan": ("buckling", *FEW, "--budget", "0.02"),
    "cost": ("passive", *FEW, "--budget", "0.1", "--target", "1e-2"),
    "solid": ("wave",),
    "dispersion": ("wave", *FEW, "-o", "d.png"),
    "spectrum": ("buckling", *FEW),
    "phases": (
        *("buckling", *FEW, "--x", "slip.2s=0:10:2", "--y", "slip.3t=0:9:2"),
        *("--levels", "0", "--start", "random", "-o", "phases"),
    ),
    "sweep": ("buckling", *FEW, "--grid", "slip.2s=0:10:2", "-o", "sweep"),
    "plot": ("run",),
    "export": ("run", "-o", "run.npz"),
    "branch": ("buckling", *FEW, "--along", "slip.2s=0:10", "--branches", "1", "-o", "branches"),
}


SLOW = {"render", "figure"}
"""Commands whose own files test the option, beside the pictures that they draw there."""

NEED_A_RUN = {"resume", "plot", "export"}
REPLACING = {name: ["--overwrite"] for name in ("run", "dispersion", "export")}
"""What a command that has run in the folder is called with again."""


def documented():
    """The keys of each command in docs/running.md, without those in brackets."""
    table = RUNNING.read_text(encoding="utf-8").split("### For scripts")[1].split("```")[0]
    for row in re.findall(r"^\| (`.*) \| (.*) \|$", table, re.M):
        outer = re.sub(r"\([^)]*\)", "", row[1])
        for name in re.findall(r"`(\w+)`", row[0]):
            yield name, set(re.findall(r"`(\w+)`", outer))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("json")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_keys_are_those_of_the_docs_and_nothing_else_is_printed(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    if name in NEED_A_RUN and not Path("run").exists():
        call("run", *COMMANDS["run"])
    shown = call(name, *COMMANDS[name], "--json")
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.isascii()
    record = json.loads(shown.stdout, parse_constant=pytest.fail)
    assert set(record) == dict(documented())[name]


def test_every_command_with_the_option_is_documented():
    assert set(dict(documented())) == set(COMMANDS) | SLOW
    for name in {*COMMANDS, *SLOW}:
        assert "--json" in call(name, "--help").stdout


def test_a_run_says_what_its_file_says(tmp_path):
    shown = call("run", "buckling", *FEW, "--verify", "-o", tmp_path, "--json")
    record, run = json.loads(shown.stdout), Trajectory.open(tmp_path)
    assert record["status"] == run.status
    assert record["time"] == run.time[-1]
    assert record["counters"] == dict(run.counters)
    assert record["trajectory"] == str(run.path)
    assert Path(record["picture"]).exists()
    assert record["position_error"] == np.nanmax(run.position_error)
    assert "slip 2s" in record["effects"]


def test_a_run_that_stops_says_why(tmp_path):
    limited = ("--set", "run.max_steps=1", "-o", tmp_path, "--json")
    shown = call("run", "buckling", *FEW, *limited)
    record = json.loads(shown.stdout)
    assert shown.exit_code == STOPPED
    assert (record["status"], record["attractor"]) == ("stopped", None)
    assert record["cause"] == Trajectory.open(tmp_path).cause.value == "budget-reached"
    assert record["reason"] in shown.stderr


def test_a_refusal_prints_no_object(tmp_path):
    shown = call("run", "buckling", "--set", "run.end=-1", "-o", tmp_path, "--json")
    assert_refused(shown, "run.end = -1")
    assert shown.stdout == ""


@pytest.mark.parametrize(
    "name",
    few_of(
        ["run", "resume", "dispersion", "phases", "branch", "sweep", "plot", "export"],
        {"run", "resume", "phases", "sweep", "plot", "export"},
    ),
)
def test_quiet_prints_nothing(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    if name in NEED_A_RUN and not Path("run").exists():
        call("run", *COMMANDS["run"])
    shown = call(name, *COMMANDS[name], "-q", *REPLACING.get(name, []))
    assert (shown.exit_code, shown.stdout) == (0, "")


@pytest.mark.parametrize("options", [("--json", "-q"), ("-v", "-q"), ("--json", "-v")])
def test_options_that_contradict_are_refused(tmp_path, options):
    shown = call("run", "buckling", "-o", tmp_path / "new", *options)
    assert_refused(shown, "exclude each other", code=REFUSED)
    assert not (tmp_path / "new").exists()


def test_a_report_has_ten_lines_at_most_and_tables_on_demand(tmp_path):
    shown = call("run", "buckling", *FEW, "--verify", "-o", tmp_path / "short")
    lines = shown.stdout.splitlines()
    assert 5 <= len(lines) <= 10
    steps = Trajectory.open(tmp_path / "short").counters["steps"]
    assert f"steps       {steps}, with" in shown.stdout
    full = call("run", "buckling", *FEW, "-o", tmp_path / "full", "-v")
    for part in ("Jacobians", "simulated", "left out"):
        assert part in full.stdout


def test_numbers_that_json_has_not_are_null_or_pairs():
    record = {"a": np.array([1.0, np.nan, np.inf]), "b": 1 + 2j, "c": Path("x"), "d": {1: "é"}}
    again = json.loads(json_text(record))
    assert again == {"a": [1.0, None, None], "b": [1.0, 2.0], "c": "x", "d": {"1": "é"}}


@pytest.mark.parametrize("name", COMMANDS)
def test_text_is_no_wider_than_80_columns(name, folder, monkeypatch):
    """Except paths and commands to copy. Diagrams and branches of the folder are not run again."""
    monkeypatch.chdir(folder)
    if name in NEED_A_RUN and not Path("run").exists():
        call("run", *COMMANDS["run"])
    further = ["-v"] if name in ("run", "resume") else []
    shown = call(name, *COMMANDS[name], *further, *REPLACING.get(name, []))
    assert shown.exit_code == 0, shown.stderr
    lines = [line.rstrip() for line in shown.stdout.splitlines()]
    assert [line for line in lines if len(line) > 80 and "nrchain run" not in line] == []
