"""Results by name, kept in a folder as they come: one line of JSON each.

A program that is killed loses at most the line that it writes. The request lies beside the results,
and a folder takes no results of another one.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nrchain.errors import TrajectoryError, shorten
from nrchain.trajectory.file import file_errors
from nrchain.trajectory.write_lock import WriteLock

REQUEST, RESULTS = "request.json", "results.jsonl"

Result = Mapping[str, Any]
"""Numbers, texts and lists that JSON holds without loss."""

MISSING = "nothing"

CONSTANTS = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


class Ledger:
    """The results of a request, by name; with a ``folder``, on disk too."""

    def __init__(self, results: dict[str, Result], folder: Path | None = None) -> None:
        self.results = results
        self.folder = folder

    def add(self, name: str, result: Result) -> None:
        """Keep a result."""
        line = json.dumps({"name": name, **result}) + "\n"
        self.results[name] = _read(line)[1]
        if self.folder is None:
            return
        with file_errors(self.folder, "cannot be written"), (self.folder / RESULTS).open("a") as f:
            f.write(line)


@contextmanager
def opened(folder: Path, request: Mapping[str, Any], *, overwrite: bool) -> Iterator[Ledger]:
    """The ledger of a request in a folder, with what is finished; nobody else may write to it.

    Raises :class:`~nrchain.errors.TrajectoryError` for a folder that holds another request.
    """
    with file_errors(folder, "cannot be made"):
        folder.mkdir(parents=True, exist_ok=True)
    with file_errors(folder, "cannot be written"), WriteLock(folder / RESULTS):
        if overwrite:
            (folder / RESULTS).unlink(missing_ok=True)
            (folder / REQUEST).unlink(missing_ok=True)
        elif (folder / REQUEST).exists():
            _refuse_other(folder, request)
        else:
            _refuse_foreign(folder)
        if not (folder / REQUEST).exists():
            partial = folder / f"{REQUEST}.partial"
            partial.write_text(json.dumps(request, indent=1) + "\n", encoding="utf-8")
            os.replace(partial, folder / REQUEST)
        yield Ledger(_cut_to_whole_lines(folder), folder)


def read_request(folder: Path) -> dict[str, Any]:
    """The request of a folder."""
    path = folder / REQUEST
    with file_errors(path, "cannot be opened"):
        try:
            request: Any = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise TrajectoryError(f"{folder}: there is no phase diagram") from None
        except ValueError as error:
            raise TrajectoryError(f"{path}: is damaged: {error}") from None
    if not isinstance(request, dict):
        raise TrajectoryError(f"{path}: is damaged: it holds no table")
    return request


def read_results(folder: Path) -> dict[str, Result]:
    """All results of a folder that are whole."""
    return _parse(folder)[0]


def _cut_to_whole_lines(folder: Path) -> dict[str, Result]:
    """The results; a line that was cut short is removed from the file."""
    results, whole = _parse(folder)
    path = folder / RESULTS
    if path.exists() and path.stat().st_size > whole:
        os.truncate(path, whole)
    return results


def _parse(folder: Path) -> tuple[dict[str, Result], int]:
    """The results, and the bytes of the whole lines that hold them."""
    path, whole = folder / RESULTS, 0
    results: dict[str, Result] = {}
    if not path.exists():
        return results, whole
    with file_errors(path, "cannot be opened"):
        content = path.read_bytes()
    for line in content.splitlines(keepends=True):
        try:
            name, result = _read(line)
        except (ValueError, KeyError, AttributeError, TypeError):
            break
        if not line.endswith(b"\n"):
            break
        results[name] = result
        whole += len(line)
    return results, whole


def _read(line: str | bytes) -> tuple[str, Result]:
    """The name and the result of a line. All NaN are one object: equal results are equal."""
    result: Any = json.loads(line, parse_constant=lambda word: CONSTANTS[word])
    return result.pop("name"), result


def _refuse_foreign(folder: Path) -> None:
    if (folder / RESULTS).exists():
        raise TrajectoryError(
            f"{folder / RESULTS}: has no {REQUEST} beside it; choose another folder"
        )


def _refuse_other(folder: Path, request: Mapping[str, Any]) -> None:
    """Raise if the folder holds another request, with what differs."""
    held = json.loads(json.dumps(read_request(folder)))
    asked = json.loads(json.dumps(request))
    both = {
        key: (held.get(key, MISSING), asked.get(key, MISSING))
        for key in dict.fromkeys([*held, *asked])
    }
    differ = [
        f"{key} is {shorten(there)} there and {shorten(here)} here"
        for key, (there, here) in both.items()
        if there != here
    ]
    if differ:
        raise TrajectoryError(
            f"{folder}: holds another phase diagram: {'; '.join(differ)}; choose another folder, or"
            " replace it with overwrite=True (--overwrite)"
        )
