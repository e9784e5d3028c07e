"""Checks of recordings and answers: each a function from the evidence to its findings, thresholds beside it."""
