"""A command with wrong input prints one line and exits with a code."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import assert_refused, call

from nrchain import __version__
from nrchain.cli.exits import REFUSED
from nrchain.errors import BackendError
from nrchain.run.interruption import INTERRUPTED


@pytest.mark.parametrize(
    ("error", "part"),
    [
        (BackendError("PyStokes 9.9 is unknown"), "PyStokes 9.9 is unknown"),
        (PermissionError(13, "Permission denied", "some/file"), "some/file: Permission denied"),
    ],
)
def test_errors_of_backends_and_files_are_one_line(tmp_path, stub, error, part):
    stub.error = error
    assert_refused(call("run", "passive", "-o", tmp_path), part)


def test_a_bug_keeps_its_traceback(tmp_path, stub):
    stub.error = ZeroDivisionError("ours")
    assert isinstance(call("run", "passive", "-o", tmp_path).exception, ZeroDivisionError)


@pytest.mark.parametrize("command", ["resume", "plot"])
def test_a_missing_run_is_refused(tmp_path, command):
    assert_refused(call(command, tmp_path), tmp_path, "no such trajectory")


@pytest.mark.parametrize("command", ["plot", "resume"])
def test_a_run_in_the_folder_runs_is_suggested(tmp_path, stub, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    assert call("run", "passive").exit_code == 0
    meant = Path("runs") / "passive"
    assert_refused(call(command, "passive"), f"did you mean {meant}?")
    assert call(command, meant).exit_code == 0
    assert_refused(call(command, "other"), "there is no such trajectory")


@pytest.mark.parametrize("name", ["x" * 300, "d/" * 3000 + "x.h5"])
def test_impossible_paths_are_refused(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(call("run", "passive", "-o", name), "cannot be made")
    for command in ("resume", "plot"):
        assert_refused(call(command, name))


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["frob"], ["frob", "nrchain --help"]),
        (["runn"], ["Did you mean 'run'? see nrchain --help"]),
        (["run"], ["SCENE", "nrchain run --help"]),
        (["run", "passive", "--foo"], ["--foo", "nrchain run --help"]),
        (["plot", ".", "--view", "top"], ["'--view': 'top' is not one of 'planes'"]),
        (["plot", ".", "--at", "x"], ["'--at': must be a number;"]),
        (["sweep", "passive", "--samples", "1.5"], ["'--samples': must be a whole number;"]),
        (["plot", ".", "--times", "0"], ["times"]),
        (["run", "passive", "--set"], ["--set"]),
        (["run", "passive", "--set", ".=1"], ["'.=1'", "key=value"]),
    ],
)
def test_a_wrong_command_line_prints_one_line(tmp_path, monkeypatch, arguments, parts):
    monkeypatch.chdir(tmp_path)
    result = call(*arguments)
    assert result.exit_code == REFUSED
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("nrchain: ")
    for part in parts:
        assert part.lower() in result.stderr.lower()


def test_no_command_shows_the_commands():
    result = call()
    assert result.exit_code == 0
    assert "resume" in result.stdout


def test_version():
    assert call("--version").stdout.strip() == f"nrchain {__version__}"


HEAVY = ("numpy", "scipy", "numba", "matplotlib", "h5py", "pystokes", "sksundae")


def test_help_loads_nothing_heavy():
    program = f"""
import sys
from nrchain.cli.app import main
sys.argv = ["nrchain", "--help"]
try:
    main()
finally:
    loaded = [name for name in {HEAVY} if name in sys.modules]
    assert not loaded, loaded
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for command in ("run", "plan", "resume", "scenes", "plot"):
        assert command in done.stdout


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_imports_prints_one_line(tmp_path, number):
    child = f"""
import os, sys
from nrchain.__main__ import main

class Loading:
    def find_spec(self, name, *rest):
        if name == "nrchain.planning.regime":
            os.kill(os.getpid(), {int(number)})

sys.meta_path.insert(0, Loading())
sys.argv = ["nrchain", "run", "passive"]
main()
"""
    command = [sys.executable, "-c", child]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (INTERRUPTED, "nrchain: interrupted\n")
