"""Simulated growth rates and phase velocities against the continuum laws."""
