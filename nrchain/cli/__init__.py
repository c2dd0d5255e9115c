"""The commands of the program nrchain, its tables and its terminal."""
