"""File permissions that apply to root as to any other user.

Two capabilities of Linux let root bypass file permissions. Without them, permissions apply to root
as to the owner of a file. Another user would not do: it cannot enter directories of root.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

VERSION = 0x20080522
"""_LINUX_CAPABILITY_VERSION_3, the version of the structures below."""

PAST_PERMISSIONS = 1 << 1 | 1 << 2
"""CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH."""


class _Header(ctypes.Structure):
    _fields_ = (("version", ctypes.c_uint32), ("pid", ctypes.c_int))


class _Set(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_uint32) for name in ("effective", "permitted", "inheritable"))


@contextmanager
def permissions_bind(folder: Path) -> Iterator[bool]:
    """Drop the capabilities of root where possible; yield whether permissions apply.

    The test is a file in ``folder`` without read permission.
    """
    sets = _capabilities() if sys.platform == "linux" else None
    if sets is None:
        yield _bound(folder)
        return
    before = sets[0].effective
    _set_effective(sets, before & ~PAST_PERMISSIONS)
    try:
        yield _bound(folder)
    finally:
        _set_effective(sets, before)


def _capabilities() -> ctypes.Array[_Set] | None:
    """The capabilities of this thread, in two words of 32 bits; None if unavailable."""
    sets = (_Set * 2)()
    try:
        failed = ctypes.CDLL(None).capget(ctypes.byref(_Header(VERSION, 0)), sets)
    except (AttributeError, OSError):
        return None
    return None if failed else sets


def _set_effective(sets: ctypes.Array[_Set], effective: int) -> None:
    sets[0].effective = effective
    if ctypes.CDLL(None, use_errno=True).capset(ctypes.byref(_Header(VERSION, 0)), sets):
        raise OSError(ctypes.get_errno(), "capset")


def _bound(folder: Path) -> bool:
    probe = folder / "probe"
    probe.write_text("")
    probe.chmod(0)
    try:
        probe.read_text()
    except PermissionError:
        return True
    finally:
        probe.unlink()
    return False
