"""One file for each effect, their base class, and the registry."""
