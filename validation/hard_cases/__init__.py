"""Hard cases: how each ends, and what completes keeps its invariants."""
