"""``nrchain run`` loads what its scene needs, when it needs it."""

import json
import subprocess
import sys

import pytest
from support.command_line import call

SCENE = ["chain.particles=5", "run.end=1", "run.snapshots=3"]
CHANGES = [word for change in SCENE for word in ("--set", change)]

PROGRAM = """
import json, sys
from contextlib import contextmanager
import nrchain.cli.run
from nrchain.__main__ import main
from numba.core.caching import Cache

found, bar, load = {}, nrchain.cli.run.progress_bar, Cache.load_overload
loaded = []

@contextmanager
def watched_bar(place, **options):
    found["before"] = [name for name in NAMES if name in sys.modules]
    with bar(place, **options) as update:
        yield update

def counted(cache, *what):
    kernel = load(cache, *what)
    loaded.append((cache._py_func.__qualname__, kernel is not None))
    return kernel

nrchain.cli.run.progress_bar = watched_bar
Cache.load_overload = counted
try:
    main()
finally:
    found["after"] = [name for name in NAMES if name in sys.modules]
    found["loaded"] = [name for name, kept in loaded if kept]
    found["compiled"] = [name for name, kept in loaded if not kept]
    print(json.dumps(found), file=sys.stderr)
"""

NAMES = ("matplotlib", "PIL", "sksundae", "pystokes", "rich.progress", "nrchain.accuracy")
"""Libraries of pictures, an integrator, pair laws and a terminal; a room that finds costs."""


def start(folder, *changes):
    """What a process of ``nrchain run`` has loaded before its run, after it, and of kernels."""
    command = [sys.executable, "-c", PROGRAM.replace("NAMES", repr(NAMES)), "run", "buckling"]
    command += ["-o", str(folder), *CHANGES, *changes]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stderr.splitlines()[-1])


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """The start of a scene whose kernels are on disk."""
    folder = tmp_path_factory.mktemp("runs")
    assert call("run", "buckling", "-o", folder / "first", *CHANGES).exit_code == 0
    return start(folder / "second")


def test_a_picture_is_loaded_after_the_run_and_what_is_not_used_never(warm):
    assert set(warm["before"]) <= {"sksundae"}
    assert set(warm["after"]) <= {"sksundae", "matplotlib", "PIL"}


def test_a_run_loads_only_its_own_integrator(tmp_path):
    assert "sksundae" not in start(tmp_path / "run", "--set", "run.integrator=radau")["after"]


def test_a_second_run_compiles_nothing_and_loads_few_kernels(warm):
    """Each kernel that Python calls is a file to load, which takes some milliseconds.

    The line on the attractor takes the derivative at the last poses, with kernels of its own.
    """
    assert warm["compiled"] == []
    assert 0 < len(warm["loaded"]) <= 26
