"""Figures of results, one kind a file: a function each, drawn when looked at."""
