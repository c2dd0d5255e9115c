"""Shared by several effects: elastic terms, slip flows, sums over images, the self-check."""
