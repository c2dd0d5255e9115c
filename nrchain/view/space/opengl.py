"""Whether OpenGL can draw without a display: asked of the libraries before VTK ends the process.

VTK ends the whole process where it finds no OpenGL. It draws off screen by EGL, or else by OSMesa,
and both are asked here as it does.
"""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache

from nrchain.errors import MissingLibraryError

PACKAGES = "libegl1 libgl1-mesa-dri"
"""Debian's packages of EGL and of Mesa's software rendering."""
WINDOW_PACKAGES = "libgl1 libgl1-mesa-dri"
"""Debian's packages of OpenGL on a display of X11."""

_PLATFORM_DEVICE = 0x313F
"""EGL_PLATFORM_DEVICE_EXT."""


def require_opengl() -> None:
    """Raise :class:`~nrchain.errors.MissingLibraryError` where nothing can be drawn off screen."""
    if sys.platform == "linux" and not _egl_works() and not _loads("libOSMesa.so.8"):
        raise MissingLibraryError(
            "drawing in three dimensions needs OpenGL, by software or by a graphics card: "
            f"apt install {PACKAGES}"
        )


def require_display() -> None:
    """Raise :class:`~nrchain.errors.MissingLibraryError` where no window can be opened."""
    if sys.platform != "linux":
        return
    if not _display_opens():
        shown = os.environ.get("DISPLAY")
        place = f"DISPLAY = {shown!r} is none" if shown else "DISPLAY is not set"
        raise MissingLibraryError(
            f"a window needs a display, and {place}; without one, write a file: -o chain.png"
        )
    if not _loads("libGL.so.1"):
        raise MissingLibraryError(f"a window needs OpenGL: apt install {WINDOW_PACKAGES}")


def _loads(library: str) -> bool:
    # VTK itself loads X11's library first, whichever it draws with
    try:
        ctypes.CDLL("libX11.so.6")
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


@cache
def _egl_works() -> bool:
    """Whether EGL starts on one of its devices; Mesa's software is one of them."""
    if not _loads("libEGL.so.1"):
        return False
    egl = ctypes.CDLL("libEGL.so.1")
    pointer, whole = ctypes.c_void_p, ctypes.c_int
    egl.eglGetProcAddress.restype = pointer
    query_at = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    display_at = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not query_at or not display_at:
        return False
    query = ctypes.CFUNCTYPE(ctypes.c_uint, whole, pointer, ctypes.POINTER(whole))(query_at)
    get_display = ctypes.CFUNCTYPE(pointer, ctypes.c_uint, pointer, pointer)(display_at)
    devices, count = (pointer * 16)(), whole(0)
    if not query(16, devices, ctypes.byref(count)):
        return False
    egl.eglInitialize.argtypes = [pointer, pointer, pointer]
    egl.eglInitialize.restype = ctypes.c_uint
    displays = (get_display(_PLATFORM_DEVICE, one, None) for one in devices[: count.value])
    return any(display and egl.eglInitialize(display, None, None) for display in displays)


@cache
def _display_opens() -> bool:
    if not _loads("libX11.so.6"):
        return False
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XCloseDisplay.argtypes = [ctypes.c_void_p]
    display = x11.XOpenDisplay(None)
    if display:
        x11.XCloseDisplay(display)
    return bool(display)
