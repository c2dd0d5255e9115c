"""Potentials: the four elastic terms of a link, their sum over a chain, and the repulsion."""
