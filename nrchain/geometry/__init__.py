"""Rotations, and which spheres are near each other."""
