"""The file of a run: layout, writing, reading, and who may write."""
