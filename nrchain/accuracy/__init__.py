"""Error against computing time, and the cost of each effect, measured on runs of a scene."""
