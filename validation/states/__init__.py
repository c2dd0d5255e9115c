"""States: what chains end in, when it changes, and how they oscillate."""
