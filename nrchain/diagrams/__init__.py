"""Phase diagrams: which attractor a chain reaches, over two numbers of its scene."""
