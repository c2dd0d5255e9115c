"""What a shell completes: commands, options, scenes, keys and values that have a name."""

from __future__ import annotations

import os

import pytest
from support.command_line import built, call, program

import nrchain
from nrchain.cli.completion import complete_key, complete_number, complete_scene
from nrchain.scene.scene import Scene


def completed(*words):
    """What bash gets for the last of the words, from the program itself."""
    request = {
        "_NRCHAIN_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(["nrchain", *words]),
        "COMP_CWORD": str(len(words)),
    }
    done = program(env=os.environ | request, stdout=-1)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.split()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("ph",), ["phases"]),
        (("run", "wave", "--verif"), ["--verify"]),
        (("run", "helix"), ["helix-left", "helix-right"]),
        (("run", "wave", "--set", "slip.2"), ["slip.2s="]),
        (("plan", "wave", "--set", "chain.ends=c"), ["chain.ends=clamped"]),
    ],
)
def test_the_program_completes_words(words, expected):
    assert completed(*words) == expected


def test_every_key_is_completed_and_its_named_values_are_allowed():
    keys = {text.rstrip("=") for text in complete_key("")}
    sections = {
        "chain",
        "elasticity",
        "slip",
        "friction",
        "steric",
        "field",
        "flow",
        "start",
        "run",
    }
    assert keys == set(Scene.spellings()) - sections
    for key in keys - {"start.shape"}:
        for assignment in complete_key(f"{key}="):
            name, _, value = assignment.partition("=")
            plain = {"true": True, "false": False}.get(value, value)
            beside = {"steric.kind": {"steric.strength": 1.0}, "effects": {"tolerance": 0.1}}
            extra = beside.get(name, {}) if value not in ("none", "named") else {}
            nrchain.load_scene("passive", **{name: plain} | extra)


def test_ranges_complete_keys_without_named_values():
    assert "slip.2s=" in complete_number("slip.")
    assert complete_number("chain.ends") == []


def test_scenes_complete_files_and_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine.toml").touch()
    (tmp_path / "wavy.toml").touch()
    (tmp_path / "wavy.txt").touch()
    assert complete_scene("wav") == ["wave", "wavy.toml"]
    assert complete_scene("fol") == ["folder/"]
    assert complete_scene("folder/m") == ["folder/mine.toml"]
    assert complete_scene("nowhere/") == []


def test_the_script_for_a_shell_is_printed(monkeypatch):
    # Typer otherwise asks which shell this process runs in
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    built.cache_clear()
    shown = call("--show-completion", "bash")
    built.cache_clear()
    assert shown.exit_code == 0
    assert "nrchain" in shown.stdout
