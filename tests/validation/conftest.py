"""Studies of a few lines in place of the real ones, and the command that runs them."""

import sys
from types import ModuleType

import pytest
from typer.testing import CliRunner

from validation.__main__ import app
from validation.report import studies


@pytest.fixture
def register(monkeypatch):
    """Make the given functions the only studies: ``register(name=function)``."""
    known = dict(studies.STUDIES)
    studies.STUDIES.clear()

    def add(**functions):
        for name, function in functions.items():
            module = ModuleType(f"stub_{name}")
            module.study = function
            monkeypatch.setitem(sys.modules, module.__name__, module)
            studies.STUDIES[name] = studies.Study(module.__name__, f"The study {name}")

    yield add
    studies.STUDIES.clear()
    studies.STUDIES.update(known)


@pytest.fixture
def command():
    """Run ``python -m validation`` with arguments, and return its result."""

    def run(*arguments):
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    return run
