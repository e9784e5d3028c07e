"""Kinds of motion, one a file: the value that runs, the shape to ask for, and the family to choose from."""
