"""Error, time and tolerance of each integrator, by class of scene."""
