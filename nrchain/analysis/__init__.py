"""What is measured on a trajectory, and what each effect does."""
