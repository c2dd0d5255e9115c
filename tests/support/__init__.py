"""What several test files share: chains, scenes, clocks, and reference sums in plain loops."""
