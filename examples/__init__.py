"""Scripts and notebooks to start from, and the robots, bodies and log maps that they use."""
