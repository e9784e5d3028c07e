"""Blocks on a terminal, as HTML, CSV and LaTeX: the only files that know how a block looks."""
