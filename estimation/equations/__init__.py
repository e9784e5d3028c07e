"""The equations Y = W chi + rho of (14), row by row and reduced to triangular factors."""
