"""What accuracy costs in time: four work–precision maps."""
