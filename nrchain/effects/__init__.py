"""One file an effect, and the registry that gives scenes their sections."""
