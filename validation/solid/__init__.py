"""The solid: symmetry classes, moduli, uniform states of strain and work in cycles."""
