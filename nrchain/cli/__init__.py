"""The program nrchain: one file a command, its tables and its terminal."""
