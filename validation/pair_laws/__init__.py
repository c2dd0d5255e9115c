"""Pair laws: PyStokes, its adapter, the native kernels and the paper, side by side."""
