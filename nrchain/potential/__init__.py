"""The discrete elastic potential: links, its four terms, and their sum over a chain."""
