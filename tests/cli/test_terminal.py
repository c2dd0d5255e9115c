"""Output that cannot be written, and symbols that a terminal lacks."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
from support.command_line import SMALL, program

from nrchain.cli.exits import BROKEN_PIPE, REFUSED
from nrchain.cli.summary import PICTURE
from nrchain.cli.terminal import TRANSLITERATE
from nrchain.trajectory.trajectory import Trajectory


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_unwritable_output_is_reported(tmp_path):
    small = ("--set", "chain.particles=3", "--set", "run.end=0.1", "--set", "run.snapshots=2")
    with open("/dev/full", "w") as full:
        done = program("run", "passive", "-o", tmp_path, *small, stdout=full)
        listed = program("effects", stdout=full)
    answer = "standard output: No space left on device\n"
    assert (done.returncode, done.stderr) == (0, f"nrchain: note: {answer}")
    assert Trajectory.open(tmp_path).status == "completed"
    assert (listed.returncode, listed.stderr) == (REFUSED, f"nrchain: {answer}")


@pytest.mark.parametrize("command", [["effects"], ["scenes"], ["--help"], ["--version"]])
def test_a_closed_pipe_ends_a_command_silently(command):
    """As ``nrchain effects | head`` does: 128 and the number of SIGPIPE, which shells expect."""
    reader, writer = os.pipe()
    os.close(reader)
    listed = program(*command, stdout=writer)
    os.close(writer)
    assert (listed.returncode, listed.stderr) == (BROKEN_PIPE, "")
    assert BROKEN_PIPE == 128 + signal.SIGPIPE


def test_a_closed_pipe_does_not_end_a_run(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    done = program("run", "passive", "-o", tmp_path, *SMALL, stdout=writer)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
    assert Trajectory.open(tmp_path).status == "completed"
    assert (tmp_path / PICTURE).exists()


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_symbols_that_an_encoding_lacks_are_replaced(encoding):
    environment = os.environ | {"PYTHONIOENCODING": encoding, "COLUMNS": "200"}
    shown = program("effects", stdout=subprocess.PIPE, env=environment, encoding=encoding)
    assert (shown.returncode, shown.stderr) == (0, "")
    assert "slip 2s" in shown.stdout
    rows = [line for line in shown.stdout.splitlines() if line.startswith("|") and "+-" not in line]
    assert len({row.index("|", 1) for row in rows}) == 1


def test_greek_letters_are_spelt_by_name():
    shown = "λ∥d σ Ω₀ ½ (a/r)² … 字".encode("ascii", TRANSLITERATE).decode()
    assert shown == "lambdapard sigma Omega0 12 (a/r)2 ... ?"
