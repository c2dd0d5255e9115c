"""The loop that takes a scene to a trajectory, its budgets and its interruption."""
