"""From poses to motion: the model of a scene, charts, and the integrators."""
