"""What accuracy costs, measured on runs of the scene itself."""
