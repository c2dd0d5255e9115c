"""The linear theory of straight chains: endless, finite, and as a continuum rod."""
