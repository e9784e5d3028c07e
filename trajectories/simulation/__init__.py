"""Simulation of a robot with known parameters under its controller, and of what disturbs its recordings."""
