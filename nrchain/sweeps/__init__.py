"""Sweeps: one scene at many points of its keys, each run once, with what is observed."""
