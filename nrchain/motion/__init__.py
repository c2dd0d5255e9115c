"""From poses to motion: the model of a scene, coordinates (charts) and integrators."""
