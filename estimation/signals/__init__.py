"""Recordings filtered, resampled, aligned and thinned, as the equations need them."""
