"""Garbage collection in the program and in the process of others."""

import gc
import subprocess
import sys

import pytest

from nrchain.cli.garbage import no_collection


def import_badly():
    with no_collection():
        assert not gc.isenabled()
        raise ImportError


@pytest.mark.parametrize("was_on", [True, False])
def test_collection_is_as_before_afterwards_also_after_an_error(was_on):
    try:
        (gc.enable if was_on else gc.disable)()
        with pytest.raises(ImportError):
            import_badly()
        assert gc.isenabled() == was_on
    finally:
        gc.enable()


def test_objects_of_another_process_are_not_exempt():
    with no_collection():
        pass
    assert gc.get_freeze_count() == 0


def test_the_program_searches_nothing_in_its_libraries_and_collects_during_a_run(tmp_path):
    """When a run begins, its libraries are loaded and exempt, and collection is on."""
    program = """
import gc, sys
import nrchain.cli.run
from nrchain.__main__ import main

def report(*_, **__):
    few = [o for o in gc.get_objects() if getattr(o, "__module__", None) == "numba.core.types"]
    print(gc.isenabled(), gc.get_stats()[2]["collections"] - before, len(few))
    sys.exit()

before = gc.get_stats()[2]["collections"]
nrchain.cli.run.progress_bar = report
sys.argv = ["nrchain", "run", "passive"]
main()
"""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.split()[-3:] == ["True", "0", "0"], done.stderr
