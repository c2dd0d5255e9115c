"""The version of the package, which trajectory files name."""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

__version__ = "0.1.0"

RECORDED = ("numpy", "scipy", "numba", "scikit-sundae", "pystokes", "h5py")
"""The packages whose versions are kept with results."""


@cache
def versions() -> Mapping[str, str]:
    """The versions of nrchain, of Python and of the packages that a run depends on."""
    # `import nrchain` loads this module, and is to load nothing else
    import platform
    from importlib import metadata

    found = {"nrchain": __version__, "python": platform.python_version()}
    for package in RECORDED:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "not installed"
    return MappingProxyType(found)
