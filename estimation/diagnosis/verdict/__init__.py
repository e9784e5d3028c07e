"""Whether numbers may be typed into a controller, and why: one check a file."""
