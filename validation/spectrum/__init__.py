"""Finite chains: rates about states, and the strengths at which they turn unstable."""
