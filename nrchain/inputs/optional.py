"""Libraries of the extras: imported where they are used; one error names what to install."""

from __future__ import annotations

import importlib
from typing import Any

from nrchain.errors import MissingLibraryError


def optional(module: str, extra: str, what: str) -> Any:
    """The module of an optional library, for ``what``, which the extra brings.

    Raises :class:`~nrchain.errors.MissingLibraryError` if it is not installed.

    >>> optional("json", "exchange", "a trajectory as text").loads("[1]")
    [1]
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        library = module.partition(".")[0]
        raise MissingLibraryError(
            f"{what} needs {library}: pip install 'nrchain[{extra}]' ({error})"
        ) from error
