"""What a chain ends in: steady states, oscillations, irregular motion, and runs that stop."""
