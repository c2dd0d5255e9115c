"""Sums over all pairs of a long chain at near-linear cost, by a tree over its index."""
