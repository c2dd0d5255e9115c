"""Jobs that run side by side, and the ledger that keeps their results."""
