"""Recordings filtered, resampled, aligned and decimated, as the equations need them."""
