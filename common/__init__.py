"""Services that know nothing of robots: errors, locked arrays, whole files, long arrays, progress."""
