"""Examples in the docstrings of public names: each has one, and all of them run."""

import doctest
import sys
from types import ModuleType

import pytest

import nrchain

NAMES = [name for name in nrchain.__all__ if not isinstance(getattr(nrchain, name), ModuleType)]
"""Public functions and classes."""

ELSEWHERE = {"Cycle", "CycleBranch", "CycleDiagram", "SpecialCycle", "Flow", "register_effect"}
"""Shown by the examples of ``find_cycle``, ``continue_cycle``, ``flow``, and by docs/effects.md."""

LONG = {
    "continue_cycle",
    "find_cycle",
    "export",
    "film",
    "render",
    "rod_of",
    "save_figure",
    "sweep",
}
LONG |= {"Sweep", "SweepPoint", "Snapshot", "Trajectory", "simulate", "simulate_many", "describe"}
"""Examples that run chains for long, or draw."""


def examples(name):
    thing = getattr(nrchain, name)
    finder = doctest.DocTestFinder(recurse=False)
    return finder.find(
        thing, name, globs={**vars(sys.modules[thing.__module__]), "nrchain": nrchain}
    )


@pytest.mark.parametrize("name", NAMES)
def test_every_public_docstring_has_an_example(name):
    assert name in ELSEWHERE or any(test.examples for test in examples(name))


@pytest.mark.parametrize("name", sorted(set(NAMES) - ELSEWHERE - LONG))
@pytest.mark.filterwarnings("default")
def test_examples_run(name, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for test in examples(name):
        printed = []
        failed, _ = doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL).run(
            test, out=printed.append
        )
        assert not failed, "".join(printed)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LONG))
def test_long_examples_run(name, monkeypatch, tmp_path):
    test_examples_run(name, monkeypatch, tmp_path)
