"""What a plan says of each effect, and what a tolerance leaves out."""
