"""The figures of the paper: one file a figure, and the panels that several share."""
