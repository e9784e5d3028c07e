"""Robots and bodies read and written: TOML files, URDF, and descriptions that others give."""
