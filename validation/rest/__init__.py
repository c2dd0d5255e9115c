"""The straight chain at rest: what it exerts on itself, how it swims and spins."""
