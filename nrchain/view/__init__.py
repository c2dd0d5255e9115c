"""Pictures of chains and of effects."""
