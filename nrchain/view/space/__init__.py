"""Chains in three dimensions, by PyVista: still pictures, films and windows."""
