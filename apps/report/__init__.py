"""Draws and writes what the other rooms computed. Imported by the command line alone."""
