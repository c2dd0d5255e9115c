"""Flows of spheres in a viscous fluid: slip modes, sums over pairs, images, friction, PyStokes.

This room does not know scenes: positions, frames and strengths are plain arrays.
"""
