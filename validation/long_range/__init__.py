"""What all pairs and friction between spheres change."""
