"""A robot whose parameters are known, under its controller, with what disturbs its recordings."""
