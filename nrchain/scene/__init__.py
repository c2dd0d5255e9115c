"""What a user states: a scene, its sections and rules, TOML, and the poses a chain starts from."""
