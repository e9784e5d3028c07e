"""URDF in: a serial chain of a robot description, re-framed to modified DH."""

from .chain import load_urdf

__all__ = ["load_urdf"]
