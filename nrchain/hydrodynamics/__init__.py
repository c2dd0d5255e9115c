"""Flows of spheres in a viscous fluid: slip modes, sums over pairs, images, friction, PyStokes.

Nothing here knows of scenes: positions, frames and strengths come in as arrays.
"""
