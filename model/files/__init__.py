"""Robots and bodies read and written: TOML files, URDF, other frames."""
