"""The bar of progress=True: in a terminal and in a notebook, nowhere else, and never on stdout."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from contextlib import suppress
from types import SimpleNamespace

import pytest

import nrchain
from nrchain import progress
from nrchain.errors import SceneError
from nrchain.progress import Shown, bar_html, updates
from nrchain.run.recording import Progress

SHORT = {"chain.particles": 3, "run.end": 1.0, "run.snapshots": 3}


def scene(**changes):
    return nrchain.load_scene("passive", **SHORT | changes)


def in_terminal(program):
    """What a program prints to stdout, and to a terminal that is its standard error."""
    ours, theirs = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "80", "LINES": "25"}
    command = [sys.executable, "-c", program]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, env=environment)
    os.close(theirs)
    shown = b""
    # reading ends with an error once no process has the terminal open
    with suppress(OSError):
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    printed, _ = child.communicate(timeout=60)
    assert child.returncode == 0, shown.decode()
    return printed.decode(), shown.decode()


RUNS = f"""
import nrchain
scene = nrchain.load_scene("passive", **{SHORT})
nrchain.simulate(scene, progress=True)
for member in nrchain.simulate_many([scene, scene], progress=True):
    pass
print("done")
"""


def test_a_terminal_shows_a_bar_of_runs_on_standard_error_alone():
    printed, shown = in_terminal(RUNS)
    assert printed == "done\n"
    plain = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", shown)
    assert "t = 1 of 1" in plain
    assert "2 of 2 runs" in plain


@pytest.mark.parametrize("given", [None, False, True])
def test_nothing_is_printed_where_standard_error_is_no_terminal(given, capfd):
    nrchain.simulate(scene(), progress=given)
    assert capfd.readouterr() == ("", "")


def test_a_function_gets_every_report_as_before(tmp_path):
    reports = []
    nrchain.simulate(scene(), output=tmp_path / "a", progress=reports.append)
    assert [one.time for one in reports] == [0.0, 0.5, 1.0]
    assert all(isinstance(one, Progress) for one in reports)
    stopped = scene(**{"run.max_steps": 1, "run.end": 1e3})
    done = nrchain.simulate(stopped, output=tmp_path / "b")
    assert done.status == "stopped"
    nrchain.resume(tmp_path / "b", progress=reports.append)
    assert len(reports) >= 3


@pytest.mark.parametrize("given", [1, "yes", [True]])
def test_another_value_is_refused(given):
    with pytest.raises(SceneError, match=r"progress = .*must be True, False or a function"):
        nrchain.simulate(scene(), progress=given)


def test_a_notebook_shows_a_bar_that_stays(monkeypatch):
    shown = []
    place = SimpleNamespace(update=shown.append)

    def display(what, display_id):
        assert display_id
        shown.append(what)
        return place

    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace())
    fake = SimpleNamespace(HTML=str, display=display)
    monkeypatch.setitem(sys.modules, "IPython.display", fake)
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setattr(progress, "INTERVAL", 0.0)
    nrchain.simulate(scene(), progress=True)
    assert shown[0].startswith(" <progress max=")
    assert 't = 0.5 of 1 <progress value="0.5" max="1"></progress>' in shown[2]
    assert 't = 1 of 1 <progress value="1" max="1"></progress>' in shown[-1]


def test_texts_of_a_bar_are_escaped():
    assert "&lt;b&gt; <progress max" in bar_html(Shown(0.0, None, "<b>"), 0.0)


def test_an_error_goes_through_the_bar():
    with pytest.raises(ZeroDivisionError), updates(True, lambda _: Shown(0.0)):
        raise ZeroDivisionError
