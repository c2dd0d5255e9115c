"""Hard cases: how each run ends, and which invariants completed runs keep."""
