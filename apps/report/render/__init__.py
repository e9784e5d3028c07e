"""Blocks on a terminal, and as HTML: the only files that know how a block looks."""
