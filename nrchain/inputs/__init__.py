"""What a user may give: one rule a key, arrays of numbers, names that are looked up."""
