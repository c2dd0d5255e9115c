"""G(z, p) = 0: states and cycles along a number of a scene, and where they change."""
