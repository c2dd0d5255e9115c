"""States of a chain and what small changes of them do: rest, steady motion, modes, thresholds."""
