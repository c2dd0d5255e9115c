"""How fast it is, against today's practice and against itself."""
