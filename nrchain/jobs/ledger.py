"""Results by name, kept in a folder as they come: one line of JSON each.

A program that is killed loses at most the line that it writes. The request lies beside the results,
and a folder takes no results of another one. Several programs may share a folder: each writes a
file of its own, and reads those of the others.
"""

from __future__ import annotations

import json
import math
import os
import socket
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nrchain.errors import TrajectoryError, shorten
from nrchain.trajectory.file import file_errors
from nrchain.trajectory.write_lock import WriteLock, is_locked, lock_holder, lock_path

REQUEST, RESULTS = "request.json", "results.jsonl"

EVERY = "results*.jsonl"
"""The pattern of all files of results in a folder."""

Result = Mapping[str, Any]
"""Numbers, texts and lists that JSON holds without loss."""

MISSING = "nothing"

CONSTANTS = {"NaN": math.nan, "Infinity": math.inf, "-Infinity": -math.inf}


class Ledger:
    """The results of a request, by name; with the ``path`` of a file, on disk too."""

    def __init__(self, results: dict[str, Result], path: Path | None = None) -> None:
        self.results = results
        self._path = path

    def add(self, name: str, result: Result) -> None:
        """Keep a result."""
        line = json.dumps({"name": name, **result}) + "\n"
        self.results[name] = _read(line)[1]
        if self._path is None:
            return
        with file_errors(self._path, "cannot be written"), self._path.open("a") as file:
            file.write(line)


@contextmanager
def opened(
    folder: Path, request: Mapping[str, Any], *, what: str, overwrite: bool, file: str = RESULTS
) -> Iterator[Ledger]:
    """The ledger of a request in a folder, with what is finished; nobody else writes to its file.

    ``what`` says what the folder is for, in messages. The owner of the file :data:`RESULTS` is
    alone in the folder. Owners of other files work side by side.

    Raises :class:`~nrchain.errors.TrajectoryError` for a folder that holds another request, and for
    one that another program writes to.
    """
    with file_errors(folder, "cannot be made"):
        folder.mkdir(parents=True, exist_ok=True)
    with file_errors(folder, "cannot be written"), WriteLock(folder / file):
        others = [path for path in sorted(folder.glob(EVERY)) if path.name != file]
        if file == RESULTS:
            _refuse_busy(others)
        if overwrite:
            for path in (*others, folder / file, folder / REQUEST):
                path.unlink(missing_ok=True)
        _claim(folder, request, what)
        own = _cut_to_whole_lines(folder / file)
        yield Ledger(read_results(folder) | own, folder / file)


def read_request(folder: Path, what: str) -> dict[str, Any]:
    """The request of a folder; ``what`` says what the folder is for."""
    path = folder / REQUEST
    with file_errors(path, "cannot be opened"):
        try:
            request: Any = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise TrajectoryError(f"{folder}: there is no {what}") from None
        except ValueError as error:
            raise TrajectoryError(f"{path}: is damaged: {error}") from None
    if not isinstance(request, dict):
        raise TrajectoryError(f"{path}: is damaged: it holds no table")
    return request


def read_results(folder: Path) -> dict[str, Result]:
    """All results of a folder that are whole."""
    found: dict[str, Result] = {}
    for path in sorted(folder.glob(EVERY)):
        found |= _parse(path)[0]
    return found


def _claim(folder: Path, request: Mapping[str, Any], what: str) -> None:
    """Write the request into the folder, or check that it holds the same."""
    if not (folder / REQUEST).exists():
        held = next(iter(sorted(folder.glob(EVERY))), None)
        if held is not None:
            raise TrajectoryError(f"{held}: has no {REQUEST} beside it; choose another folder")
        partial = folder / f"{REQUEST}.{socket.gethostname()}.{os.getpid()}.partial"
        partial.write_text(json.dumps(request, indent=1) + "\n", encoding="utf-8")
        os.replace(partial, folder / REQUEST)
    # also after writing it: another program may have been as fast
    _refuse_other(folder, request, what)


def _refuse_busy(others: Iterable[Path]) -> None:
    """Raise if another program writes to one of these files."""
    for path in others:
        if is_locked(lock_path(path)):
            raise TrajectoryError(f"{path}: {lock_holder(lock_path(path))} is writing to it")


def _cut_to_whole_lines(path: Path) -> dict[str, Result]:
    """The results of a file; a line that was cut short is removed from it."""
    results, whole = _parse(path)
    if path.exists() and path.stat().st_size > whole:
        os.truncate(path, whole)
    return results


def _parse(path: Path) -> tuple[dict[str, Result], int]:
    """The results of a file, and the bytes of the whole lines that hold them."""
    whole = 0
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


def _refuse_other(folder: Path, request: Mapping[str, Any], what: str) -> None:
    """Raise if the folder holds another request, with what differs."""
    held = json.loads(json.dumps(read_request(folder, what)))
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
            f"{folder}: holds another {what}: {'; '.join(differ)}; choose another folder, or"
            " replace it with overwrite=True (--overwrite)"
        )
