"""Weighted least squares (17) to (21), its covariances, and what is essential."""
