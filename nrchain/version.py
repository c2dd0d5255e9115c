"""The version of the package, which trajectory files name."""

__version__ = "0.1.0"
