"""Have one module of a process loaded as a mutant, whatever is on disk."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
import sys
from pathlib import Path
from types import CodeType

from validation.mutants.sites import mutated

VARIABLE = "NRCHAIN_MUTANT"
"""Holds the file and the number of the mutant that a process runs: ``file:number``."""


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, name: str, path: str, number: int) -> None:
        super().__init__(name, path)
        self._number = number

    def get_code(self, fullname: str) -> CodeType:
        source = Path(self.path).read_text(encoding="utf-8")
        return compile(mutated(source, self._number), self.path, "exec", dont_inherit=True)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, path: str, number: int) -> None:
        self._path, self._number = os.path.realpath(path), number

    def find_spec(self, fullname, path=None, target=None):
        if not fullname.startswith("nrchain"):
            return None
        spec = importlib.machinery.PathFinder.find_spec(fullname, path, target)
        if spec is None or spec.origin is None or os.path.realpath(spec.origin) != self._path:
            return None
        spec.loader = _Loader(fullname, spec.origin, self._number)
        return spec


def load_as_mutant(mutant: str) -> None:
    """From here on, the file of ``file:number`` is imported with that change."""
    path, _, number = mutant.rpartition(":")
    sys.meta_path.insert(0, _Finder(path, int(number)))
