"""Bodies and robots that can exist: constraints, the nearest one, intervals."""
