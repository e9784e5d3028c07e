"""What speaks against recordings and results: mistakes in logs, causes, checks, the verdict."""
