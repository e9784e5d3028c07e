"""What a log holds, and what looks wrong with it."""
