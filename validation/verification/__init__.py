"""The error that a run estimates of itself, against its error."""
