"""The linear theory of straight chains, infinite, finite and as a rod, and the solid they make."""
