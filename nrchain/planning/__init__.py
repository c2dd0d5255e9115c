"""What a scene foretells before it runs, and which effects it needs."""
