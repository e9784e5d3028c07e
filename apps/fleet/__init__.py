"""Many recordings: reduced in parallel, stored, compared."""
