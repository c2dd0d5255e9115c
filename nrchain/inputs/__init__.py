"""Checks of user input: a rule for each key, arrays of numbers, and names."""
