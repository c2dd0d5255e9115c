"""The flow of the fluid at any points, against PyStokes and resolved spheres."""
