"""The linear theory of straight chains: infinite, finite, and as a continuous rod."""
