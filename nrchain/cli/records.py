"""Results as one JSON object on standard output, for scripts."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from nrchain.cli.exits import show


def show_json(record: Mapping[str, Any]) -> None:
    """Print a record as one JSON object; numbers that are not finite become null."""
    show(json_text(record), soft_wrap=True)


def json_text(record: Mapping[str, Any]) -> str:
    """The JSON of a record, in ASCII and in one line."""
    return json.dumps(_plain(record), ensure_ascii=True, allow_nan=False)


def _plain(value: Any) -> Any:
    """A value as JSON can hold it: arrays as lists, complex numbers as pairs, paths as text."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Enum):
        return _plain(value.value)
    return str(value) if isinstance(value, Path) else value
