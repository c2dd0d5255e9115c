"""Rotations, and pairs of spheres near each other."""
