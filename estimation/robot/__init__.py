"""The robot's own base parameters from recordings without payload."""
